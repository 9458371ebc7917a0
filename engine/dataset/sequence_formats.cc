// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/sequence_formats.h"

#include "engine/dataset/asl_sequence.h"
#include "engine/dataset/plumbline_sequence.h"

namespace plumbline {
namespace {

constexpr SequenceFormat kFormats[] = {
    {"plumbline", "Plumbline's own layout", "a folder with camera.json and color/ or tracks.csv",
     true, ProbePlumblineSequence, OpenPlumblineSequence},
    {"asl", "the ASL layout of EuRoC and TUM-VI", "a folder with mav0/cam0/data.csv", false,
     ProbeAslSequence, OpenAslSequence},
};

}  // namespace

std::span<const SequenceFormat> SequenceFormats() { return kFormats; }

const SequenceFormat* FindSequenceFormat(const std::filesystem::path& path) {
  const SequenceFormat* best = nullptr;
  Likeness surest = Likeness::kNone;
  for (const SequenceFormat& format : kFormats) {
    const Likeness likeness = format.probe(path);
    if (likeness <= surest) continue;
    surest = likeness;
    best = &format;
  }
  return best;
}

}  // namespace plumbline
