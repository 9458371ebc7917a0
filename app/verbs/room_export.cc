// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/room_export.h"

#include <algorithm>
#include <cstdio>

#include "app/verbs/console_work.h"
#include "engine/snapshot/export_formats.h"

namespace plumbline {
namespace {

/// What is only said of what somebody placed, or needs a scan.
bool OfAnnotationsOnly(const std::string& format) {
  return format == "ground_truth" || format == "visma";
}

/// What a run's map holds, as posed objects; its world is the scan's frame.
AnnotationDocument DocumentOf(const RunHeader& header, const std::vector<EstimatedObject>& objects,
                              const std::filesystem::path& run) {
  AnnotationDocument document;
  document.gravity_in_scan = header.gravity_in_world.normalized();
  document.floor_in_scan = header.floor_in_world;
  for (const EstimatedObject& object : objects) {
    AnnotatedInstance instance;
    instance.id = object.model + "_" + object.id;
    instance.model = object.model;
    instance.category = object.category;
    instance.scan_from_object = object.world_from_object;
    instance.scale = object.scale;
    instance.fine = false;
    instance.note = "object " + object.id + " of " + run.filename().string();
    document.instances.push_back(std::move(instance));
  }
  return document;
}

const ExportFormat& FormatNamed(const std::string& name) {
  return *std::find_if(kExportFormats.begin(), kExportFormats.end(),
                       [&](const ExportFormat& format) { return format.name == name; });
}

}  // namespace

std::vector<std::string> RoomFormats(ExportedFrom from) {
  std::vector<std::string> names;
  for (const ExportFormat& format : kExportFormats) {
    if (from == ExportedFrom::kAnnotation || !OfAnnotationsOnly(format.name))
      names.emplace_back(format.name);
  }
  return names;
}

std::string RoomFormatsHelp(ExportedFrom from) {
  std::string help;
  for (const std::string& name : RoomFormats(from)) {
    const ExportFormat& format = FormatNamed(name);
    help += (help.empty() ? "" : " ") + name + ": " + format.what;
  }
  return help + " docs/exports.md has the conventions of each.";
}

GltfUp UpFrom(const std::string& name) { return name == "z" ? GltfUp::kZ : GltfUp::kY; }

Status WriteAndSay(const AnnotationDocument& document, const ExchangeInputs& inputs,
                   const std::filesystem::path& scan_file, const ExportRequest& request,
                   const std::string& remark) {
  ConsoleWork work;
  const auto staged = StagedExport::Write(document, inputs, scan_file, request, work.context());
  if (!staged) return staged.error();
  const std::vector<std::string> differences = (*staged)->Differences();
  const auto kept = (*staged)->Take();
  if (!kept) return kept.error();
  std::printf("%s: %zu instances%s\n", request.out.c_str(), document.instances.size(),
              remark.c_str());
  for (const std::string& difference : differences) std::printf("  %s\n", difference.c_str());
  if (!kept->empty()) std::printf("  what was there is kept as %s\n", kept->c_str());
  return {};
}

std::vector<int> ChosenFrames(const Sequence* sequence, const FrameRange& range) {
  std::vector<int> frames;
  if (sequence == nullptr) return frames;
  const int count = sequence->num_frames(), end = std::min(count, range.end.value_or(count));
  for (int i = range.begin; i < end; i += range.step) frames.push_back(i);
  return frames;
}

Status ExportRoomOfRun(const RunChoice& choice, const RunHeader& header,
                       const std::vector<EstimatedObject>& objects, const ExportRequest& request,
                       const std::string& frames) {
  const auto models = LoadModelsOfRun(choice, header);
  if (!models) return models.error();
  std::shared_ptr<const Sequence> sequence;
  if (FormatNamed(request.format).needs_sequence) {
    auto opened = OpenSequenceOfRun(choice, header);
    if (!opened) {
      return Error{opened.error().code,
                   opened.error().message + "; name the sequence of the run with --sequence DIR"};
    }
    sequence = std::move(*opened);
  }
  const Result<FrameRange> range =
      frames.empty() ? Result<FrameRange>(header.recipe.frames) : ParseFrameRange(frames);
  if (!range) return range.error();
  return WriteAndSay(DocumentOf(header, objects, choice.run),
                     {models->get(), sequence.get(), ChosenFrames(sequence.get(), *range), nullptr},
                     "", request, "");
}

}  // namespace plumbline
