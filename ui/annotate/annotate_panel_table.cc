// SPDX-License-Identifier: Apache-2.0
#include <string_view>

#include "ui/annotate/annotate_panels.h"

namespace plumbline {
namespace {

constexpr AnnotatePanelEntry kPanels[] = {
    {{"annotate_models", "Models",
      "The shapes of the database. Click one, then click in the scan where it stands."},
     MakeAnnotateModelsPanel},
    {{"annotate_instances", "Placed",
      "What stands in the scan so far. Click one to select it (Ctrl: one more, Shift: all up to "
      "it), "
      "double click to look at it."},
     MakeAnnotateInstancesPanel},
    {{"annotate_scene", "Scan",
      "The scan with the models in it, z up. Left drag turns, right drag (or middle, or Shift and "
      "left) moves, the wheel zooms, double click turns about what is under the mouse."},
     MakeAnnotateScenePanel},
    {{"annotate_images", "In the images",
      "The selected object's outline in key frames from different sides; dashed where it is "
      "hidden. It follows while the object is moved. A click shows the scan from there."},
     MakeAnnotateImagesPanel},
    {{"annotate_frame", "Frame",
      "A frame of the sequence: click where a point of the scan is seen. Wheel zooms, dragging "
      "moves, double click shows all. Crosses: what was clicked; circles: where the scan's points "
      "are seen by the registration."},
     MakeAnnotateFramePanel},
    {{"annotate_masks", "Masks in a frame",
      "Which object shows at which pixel of a frame, as 'export --format bop' writes it; hidden "
      "objects count, too. A click selects one. Wheel zooms, dragging moves."},
     MakeAnnotateMasksPanel},
    {{"annotate_floor", "Floor and gravity",
      "The direction of gravity. Everything that is placed stands upright with respect to it."},
     MakeAnnotateFloorPanel},
    {{"annotate_candidates", "Which way round?",
      "24 azimuths were tried, each aligned to the scan; these are the different results, the best "
      "first. Up and down or a click choose one, Enter or a double click takes it."},
     MakeAnnotateCandidatesPanel},
    {{"annotate_refinement", "Refine",
      "The model is aligned from where it is, upright all the while: to the scan (colours show how "
      "far its surface is from it), or to the edges in the images."},
     MakeAnnotateRefinementPanel},
    {{"annotate_sequence", "Sequence in the scan",
      "Where the frame of the sequence's poses is in the scan: a turn about gravity and a shift. "
      "Without it, both share one frame."},
     MakeAnnotateSequencePanel},
    {{"annotate_crop", "Cut out",
      "An object is cut out of the scan: it becomes a model of the database that stands where it "
      "was, or a fragment of a VISMA folder. The scan itself does not change."},
     MakeAnnotateCropPanel},
    {{"annotate_instance", "Object",
      "The selected object. Drag it in the scan to move it along the floor, its ring to turn it, "
      "its arrow to lift it; or type numbers here."},
     MakeAnnotateInstancePanel},
};

}  // namespace

std::span<const AnnotatePanelEntry> AnnotatePanels() { return kPanels; }

std::unique_ptr<Panel> MakeAnnotatePanel(std::string_view id) {
  for (const AnnotatePanelEntry& entry : kPanels) {
    if (id != entry.info.id) continue;
    std::unique_ptr<Panel> panel = entry.make();
    panel->set_info(entry.info);
    return panel;
  }
  return nullptr;
}

}  // namespace plumbline
