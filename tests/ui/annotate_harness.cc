// SPDX-License-Identifier: Apache-2.0
#include "tests/ui/annotate_harness.h"

#include <numbers>
#include <utility>

#include "ui/annotate/annotate_actions.h"
#include "ui/framework/actions.h"
#include "ui/framework/layout.h"

namespace plumbline {
namespace {

cv::Mat Grey(int width, int height) { return {height, width, CV_8UC3, cv::Scalar(90, 90, 90)}; }

AnnotationModel ModelNamed(const std::string& name, float half_m) {
  AnnotationModel model;
  model.name = name;
  model.category = name == "armchair" ? "chair" : "dining table";
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices = {{-half_m, -half_m, 0}, {half_m, -half_m, 0}, {0, half_m, 1}};
  mesh->triangles = {{0, 1, 2}};
  model.mesh = mesh;
  model.bounds = {Eigen::Vector3f(-half_m, -half_m, 0), Eigen::Vector3f(half_m, half_m, 1)};
  model.on_floor = true;
  model.thumbnail = Grey(144, 108);
  return model;
}

AnnotatedInstance InstanceAt(const std::string& id, const std::string& model, double x, double y) {
  AnnotatedInstance instance;
  instance.id = id;
  instance.model = model;
  instance.category = "chair";
  instance.annotator = "Ada";
  instance.seconds_spent = 75;
  instance.scan_from_object.translation() = Eigen::Vector3d(x, y, 0);
  return instance;
}

}  // namespace

PlacementView MadeUpPlacement() {
  PlacementView placement;
  placement.model = 0;
  placement.running = false;
  placement.seconds = 0.25;
  for (int i = 0; i < 2; ++i) {
    PlacementCandidate candidate;
    candidate.id = i;
    candidate.scan_from_object.translation() = Eigen::Vector3d(i, 0, 0);
    candidate.fitness = 0.9 - 0.2 * i;
    candidate.rmse_m = 0.004;
    candidate.azimuth_rad = i * std::numbers::pi / 2;
    candidate.picture = Grey(208, 156);
    placement.candidates.push_back(std::move(candidate));
  }
  return placement;
}

AnnotateHarness::AnnotateHarness() {
  size = {420, 700};
  ImGui::GetIO().DisplaySize = {1200, 900};
  ImGuiIO& io = ImGui::GetIO();
  io.KeyMap[ImGuiKey_Escape] = keys::kEscape;
  io.KeyMap[ImGuiKey_Enter] = keys::kEnter;
  io.KeyMap[ImGuiKey_Tab] = keys::kTab;
  io.KeyMap[ImGuiKey_A] = keys::kA;
  io.KeyMap[ImGuiKey_Delete] = keys::kDelete;
  AnnotationSnapshot& s = *snapshot_;
  s.state = AnnotationSnapshot::State::kReady;
  s.project_file = "/data/room.annotation.json";
  s.project_name = "room.annotation.json";
  s.scan_name = "room.ply";
  auto scan = std::make_shared<TriangleMesh>();
  scan->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  s.scan = s.scan_coarse = scan;
  s.scan_points = 3;
  s.ready_to_align = s.floor_known = s.gravity_known = true;
  s.models = std::make_shared<const std::vector<AnnotationModel>>(
      std::vector{ModelNamed("armchair", 0.4f), ModelNamed("table", 0.7f)});
  s.models_version = 1;
  s.instances = {InstanceAt("armchair_0", "armchair", 1, -1),
                 InstanceAt("table_0", "table", 3, -2)};
  s.selected = "armchair_0";
  s.has_sequence = true;
  s.num_frames = 40;
  s.frame_size = {160, 90};
  context.annotation = snapshot_;
  context.annotation_version = 1;
  context.workspace = WorkspaceId::kAnnotate;
  context.annotate = &view;
  context.annotate_scene = &surface;
}

std::string AnnotateHarness::Text(Panel& panel) {
  ImGui::GetIO().MousePos = {-1, -1};  // a tooltip would end the text
  Draw(panel, 2);                      // sizes that are those of the last frame
  ImGui::NewFrame();
  widgets.Clear();
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize(ImGui::GetIO().DisplaySize);
  ImGui::Begin("test", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove);
  ImGui::LogToClipboard();
  DrawPanel(context, {{20, 20}, {20 + size.x, 20 + size.y}}, panel, sink);
  ImGui::LogFinish();
  ImGui::End();
  ImGui::Render();
  const char* text = ImGui::GetClipboardText();
  return text == nullptr ? "" : text;
}

void AnnotateHarness::Type(Panel& panel, const std::string& widget, const std::string& text,
                           int leave_by) {
  Click(panel, widget);
  ImGuiIO& io = ImGui::GetIO();
  io.KeyCtrl = io.KeysDown[keys::kA] = true;  // all of it
  Draw(panel);
  io.KeyCtrl = io.KeysDown[keys::kA] = false;
  Draw(panel);
  io.AddInputCharactersUTF8(text.c_str());
  Draw(panel, 2);
  io.KeysDown[leave_by] = true;
  Draw(panel);
  io.KeysDown[leave_by] = false;
  Draw(panel, 2);
}

void AnnotateHarness::Press(int key, bool control, bool shift, bool alt) {
  ImGuiIO& io = ImGui::GetIO();
  for (const bool down : {true, false}) {
    io.KeysDown[key] = down;
    io.KeyCtrl = down && control;
    io.KeyShift = down && shift;
    io.KeyAlt = down && alt;
    ImGui::NewFrame();
    RunKeys(actions_, context, sink);
    PostAnnotateShortcuts(context, sink);
    ImGui::Render();
  }
}

RefinementView MadeUpRefinement() {
  RefinementView refinement;
  refinement.instance = "armchair_0";
  refinement.running = false;
  refinement.converged = true;
  refinement.iteration = 12;
  refinement.fitness = 0.8;
  refinement.has_scan = true;
  refinement.before.fitness = 0.5;
  refinement.azimuth_rad = 0.1;
  refinement.azimuth_std_rad = 0.01;
  refinement.horizontal_m = 0.02;
  refinement.rmse_m = 0.003;
  refinement.before.rmse_m = 0.009;
  return refinement;
}

FloorProposal MadeUpFloor() {
  FloorProposal floor;
  floor.source = "picked";
  floor.offset_m = -0.25;
  floor.inliers = floor.outliers = std::make_shared<const std::vector<Eigen::Vector3f>>();
  floor.num_inliers = 4321;
  floor.turn_rad = 0.02;
  return floor;
}

ImageChecksView MadeUpChecks() {
  ImageChecksView checks;
  checks.instance = "armchair_0";
  checks.running = false;
  checks.agreement = 0.42;
  for (int i = 0; i < 2; ++i) {
    ImageCheckView check;
    check.frame = 10 * (i + 1);
    check.image = cv::Mat(90, 160, CV_8UC3, cv::Scalar(60, 60, 60));
    check.scan_from_cam.translation() = Eigen::Vector3d(i, 2, 3);
    check.lines = {{false, false, {{10, 10}, {60, 60}}}, {true, true, {{20, 10}, {60, 20}}}};
    check.agreement = 0.4;
    checks.images.push_back(check);
  }
  return checks;
}

SequenceAlignmentView MadeUpAlignment() {
  SequenceAlignmentView alignment;
  alignment.how = "objects";
  alignment.running = false;
  alignment.turn_rad = 0.5;
  alignment.shift_m = 0.123;
  alignment.rmse_m = 0.02;
  alignment.residuals = {{"table 2", 0.015}, {"chair 4", -1}};
  return alignment;
}

CropView MadeUpCrop() {
  CropView crop{"stool"};
  crop.running = false;
  crop.size_m = {0.4, 0.5, 0.6};
  crop.num_faces = 900;
  crop.points = std::make_shared<const std::vector<Eigen::Vector3f>>(7);
  return crop;
}

}  // namespace plumbline
