// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/annotate_images.h"

namespace plumbline {

void AddImageOptions(CLI::App& command, ImageArguments& arguments, const char* least_frames) {
  command
      .add_option("--frames", arguments.frames,
                  std::string("Key frames that each object is compared in, from as different sides "
                              "as there are; ") +
                      least_frames)
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command
      .add_option("--among", arguments.among,
                  "Take them from these frames of the sequence alone (B excluded)")
      ->type_name("A:B[:S]");
  command
      .add_option(
          "--edges", arguments.edges,
          "dataset (the sequence's), gradient or a network; the sequence's where it has any, "
          "else gradient")
      ->type_name("dataset|gradient|FILE.onnx");
}

void AddRefineOptions(CLI::App& command, RefineArguments& arguments) {
  command
      .add_option("--instance", arguments.instances,
                  "Only this one (may be given several times); else all that are not locked")
      ->type_name("ID");
  command
      .add_option("--by", arguments.by,
                  "both: scan and images together, weighted by their covariances (where there is "
                  "but one, that one); or one of them alone")
      ->check(CLI::IsMember({"both", "scan", "images"}))
      ->capture_default_str();
  command.add_flag("--all-azimuths", arguments.all_azimuths,
                   "First try all azimuths by the images alone, up to 30 cm around; what they "
                   "clearly prefer (by 0.2 of agreement) is where the refinement begins. 5 to 15 s "
                   "an object");
  command
      .add_option("--camera-std", arguments.camera_std_cm,
                  "By how much all cameras together may be off in the scan, along each axis [cm]; "
                  "0 for synthetic sequences")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command
      .add_option("--max-shift", arguments.options.max_shift_m,
                  "How far it may move across and along gravity [m]")
      ->check(CLI::Range(0.001, 1.0))
      ->capture_default_str();
  command.add_option("--max-turn", arguments.options.max_turn_deg, "How far it may turn [degrees]")
      ->check(CLI::Range(0.1, 90.0))
      ->capture_default_str();
  command
      .add_option("--dof", arguments.dof,
                  "What is free: 4 azimuth and translation, 3 azimuth and the two translations "
                  "along the floor, 1 azimuth alone")
      ->check(CLI::IsMember({4, 3, 1}))
      ->capture_default_str();
}

}  // namespace plumbline
