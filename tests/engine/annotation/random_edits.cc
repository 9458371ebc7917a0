// SPDX-License-Identifier: Apache-2.0
#include "tests/engine/annotation/random_edits.h"

#include "engine/geometry/random_vector.h"
#include "tests/support/random_pose.h"

namespace plumbline {
namespace {

std::string FreeName(const AnnotationDocument& document, Random& random) {
  std::string name;
  do {
    name = "chair_" + std::to_string(random.Bits());
  } while (document.Find(name));
  return name;
}

Edit Change(const AnnotationDocument& document, Random& random) {
  const auto& instances = document.instances;
  const auto& chosen = instances[random.Index(static_cast<std::uint32_t>(instances.size()))];
  ChangeInstance edit;
  edit.id = chosen.id;
  if (chosen.locked) edit.set.locked = false;
  switch (random.Index(8)) {
    case 0:
      edit.set.id = FreeName(document, random);
      break;
    case 1:
      edit.set.note = "seen from \"behind\"\n\xc3\xa4 " + std::to_string(random.Uniform());
      edit.set.fine = random.Index(2) == 0;
      break;
    case 2:
      edit.set.seconds_spent = chosen.seconds_spent + random.Uniform(0, 60);
      edit.set.annotator = "Ada";
      break;
    case 3:
      edit.set.locked = true;
      break;
    case 4:
      edit.set.may_tilt = !chosen.may_tilt;
      break;
    case 5:
      edit.set.scale = random.Uniform(0.8, 1.2);
      edit.set.may_scale = !chosen.may_scale;
      break;
    default:
      edit.set.scan_from_object = RandomPose(random);
      break;
  }
  return edit;
}

Edit AddOrRemoveCrop(const AnnotationDocument& document, Random& random) {
  if (document.crops.size() > 10 || (!document.crops.empty() && random.Index(3) == 0)) {
    return RemoveCrop{
        document.crops[random.Index(static_cast<std::uint32_t>(document.crops.size()))].id};
  }
  return AddCrop{RandomCrop("crop_" + std::to_string(random.Bits()), random), std::nullopt};
}

Edit AddOrRemovePair(const AnnotationDocument& document, Random& random) {
  const auto count = static_cast<std::uint32_t>(document.pairs.size());
  if (count > 10 || (count > 0 && random.Index(3) == 0)) return RemovePair{random.Index(count)};
  const FramePick pair{{random.Gaussian(), random.Gaussian(), random.Gaussian()},
                       static_cast<int>(random.Index(500)),
                       {random.Uniform(0, 640), random.Uniform(0, 480)}};
  return AddPair{pair, random.Index(count + 1)};
}

Edit AcceptOrReopen(const AnnotationDocument& document, Random& random) {
  if (!document.accepted.empty() && random.Index(3) == 0) {
    const AcceptedFinding& accepted =
        document.accepted[random.Index(static_cast<std::uint32_t>(document.accepted.size()))];
    ReopenFinding edit{accepted.kind, {}};
    for (const auto& object : accepted.objects) edit.instances.push_back(object.id);
    return edit;
  }
  const auto& instances = document.instances;
  const auto& chosen = instances[random.Index(static_cast<std::uint32_t>(instances.size()))];
  AcceptedFinding accepted{"floating", {}, random.Uniform(), "m", "Ada", "a rug"};
  accepted.objects.push_back({chosen.id, chosen.model, chosen.scale, chosen.scan_from_object});
  return AcceptFinding{accepted, std::nullopt};
}

}  // namespace

AnnotatedInstance RandomInstance(const std::string& id, Random& random) {
  AnnotatedInstance instance;
  instance.id = id;
  instance.model = "chair";
  instance.category = "chair";
  instance.scan_from_object = RandomPose(random);
  instance.fine = random.Index(2) == 0;
  instance.annotator = "Ada";
  instance.seconds_spent = random.Uniform(0, 100);
  return instance;
}

Crop RandomCrop(const std::string& id, Random& random) {
  Crop crop;
  crop.id = id;
  crop.into = random.Index(2) == 0 ? Crop::Into::kModel : Crop::Into::kFragment;
  crop.category = "chair";
  crop.without_support = random.Index(2) == 0;
  if (crop.without_support) crop.support_in_scan = Eigen::Vector4d(0, 0, 1, random.Gaussian());
  if (random.Index(2) == 0) {
    crop.region = CropBox{{random.Gaussian(), random.Gaussian(), random.Gaussian()},
                          {random.Uniform(0.1, 1), 0.5, 1},
                          random.Uniform(-3, 3)};
    return crop;
  }
  CropLasso lasso;
  lasso.scan_from_cam = RandomPose(random);
  lasso.camera = {640, 480, 500, 500, 319.5, 239.5};
  for (int i = 0; i < 5; ++i) {
    lasso.polygon_px.emplace_back(random.Uniform(0, 640), random.Uniform(0, 480));
  }
  if (random.Index(2) == 0) lasso.far_m = 3;
  if (random.Index(2) == 0) lasso.azimuth_rad = random.Uniform(-3, 3);
  crop.region = std::move(lasso);
  return crop;
}

Edit RandomEdit(const AnnotationDocument& document, Random& random) {
  const std::uint32_t kind = random.Index(15);
  if (document.instances.size() < 3 || (kind < 2 && document.instances.size() < 40)) {
    return AddInstance{RandomInstance(FreeName(document, random), random), std::nullopt};
  }
  if (kind == 2) {
    for (const AnnotatedInstance& instance : document.instances) {
      if (!instance.locked) return RemoveInstance{instance.id};
    }
  }
  if (kind == 3) {
    const Eigen::Vector3d down = GaussianVector<3>(random).normalized();
    return SetGravity{down, Eigen::Vector4d(-down.x(), -down.y(), -down.z(), random.Gaussian())};
  }
  if (kind == 4) return SetSceneAlignment{RandomPose(random)};
  if (kind == 5) return SetInputs{"scan.ply", "models", "walk" + std::to_string(random.Index(9))};
  if (kind == 7) return AddOrRemoveCrop(document, random);
  if (kind == 8) return AddOrRemovePair(document, random);
  if (kind == 10) return AcceptOrReopen(document, random);
  if (kind == 9) {
    ProjectState state{static_cast<WorkStage>(1 + random.Index(3)), "Ada", "", "note"};
    if (random.Index(2) == 0) state.reviewer = "Grace";
    return SetState{state};
  }
  if (kind == 6) {
    EditGroup group{"Two at once", {}};
    group.edits.push_back(
        AddInstance{RandomInstance(FreeName(document, random), random), std::size_t{0}});
    group.edits.push_back(Change(document, random));
    return group;
  }
  return Change(document, random);
}

}  // namespace plumbline
