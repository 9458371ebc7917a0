// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/frame_codec.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <type_traits>
#include <utility>

#include "engine/base/options.h"

namespace plumbline {
namespace {

static_assert(std::endian::native == std::endian::little, "the run file is little-endian");

// Reading and writing share one description of each struct (the Visit functions below), so that
// they cannot disagree.

class Encoder {
 public:
  static constexpr bool kReads = false;

  template <typename T>
  requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) void operator()(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void operator()(const std::string& text) {
    Count(text.size());
    bytes_ += text;
  }
  void Count(std::size_t count) { (*this)(static_cast<std::uint32_t>(count)); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// After the first value that is not there everything reads as zero and `ok` is false.
class Decoder {
 public:
  static constexpr bool kReads = true;

  explicit Decoder(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) void operator()(T& value) {
    const std::string_view part = Take(sizeof(T));
    if (part.empty()) {
      value = T{};
    } else if constexpr (std::is_same_v<T, bool>) {  // no other bytes may stand in one
      const auto byte = static_cast<unsigned char>(part.front());
      Require(byte <= 1);
      value = byte == 1;
    } else {
      std::memcpy(&value, part.data(), sizeof(T));
    }
    if constexpr (requires { EnumNames<T>::names; })
      Require(static_cast<std::size_t>(value) < std::size(EnumNames<T>::names));
  }
  void operator()(std::string& text) {
    std::uint32_t size = 0;
    (*this)(size);
    text = Take(size);
  }
  std::size_t Count() {
    std::uint32_t count = 0;
    (*this)(count);
    if (count > bytes_.size()) ok_ = false;  // every element takes a byte at least
    return ok_ ? count : 0;
  }
  /// What does not hold makes the frame a damaged one.
  void Require(bool holds) { ok_ = ok_ && holds; }
  bool AtEnd() const { return bytes_.empty(); }
  bool complete() const { return ok_ && bytes_.empty(); }

 private:
  std::string_view Take(std::size_t size) {
    if (size > bytes_.size()) ok_ = false;
    if (!ok_) return {};
    const std::string_view part = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return part;
  }

  std::string_view bytes_;
  bool ok_ = true;
};

template <typename Coder, typename Values, typename Visit>
void VisitList(Coder& code, Values& values, Visit visit) {
  if constexpr (Coder::kReads) {
    values.resize(code.Count());
  } else {
    code.Count(values.size());
  }
  for (auto& value : values) visit(value);
}

template <typename Coder, typename Optional, typename Visit>
void VisitOptional(Coder& code, Optional& value, Visit visit) {
  std::uint8_t present = value.has_value();
  code(present);
  if constexpr (Coder::kReads) {
    value.reset();
    if (present) value.emplace();
  }
  if (value) visit(*value);
}

template <typename Coder, typename Matrix>
void VisitMatrix(Coder& code, Matrix& matrix, int rows, int columns) {
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) code(matrix(row, column));
  }
}

template <typename Coder, typename Pose>
void VisitPose(Coder& code, Pose& pose) {
  VisitMatrix(code, pose.matrix(), 3, 4);
  if constexpr (Coder::kReads) pose.makeAffine();
}

/// Where an object is: written as null or compared with another it would pass for none.
template <typename Coder, typename Pose>
void VisitPlace(Coder& code, Pose& pose) {
  VisitPose(code, pose);
  if constexpr (Coder::kReads) code.Require(pose.matrix().allFinite());
}

template <typename Coder, typename Box>
void VisitBox(Coder& code, Box& box) {
  code(box.x0);
  code(box.y0);
  code(box.x1);
  code(box.y1);
}

template <typename Coder, typename Report>
void VisitFrame(Coder& code, Report& report) {
  VisitOptional(code, report.world_from_cam, [&](auto& pose) { VisitPose(code, pose); });
  VisitList(code, report.proposals, [&](auto& proposal) {
    VisitBox(code, proposal.box);
    code(proposal.category);
    code(proposal.score);
    code(proposal.fate);
    if constexpr (Coder::kReads) code.Require(proposal.fate <= ProposalFate::kImplausible);
    code(proposal.object.value);
  });
  VisitList(code, report.timings, [&](auto& timing) {
    code(timing.stage);
    code(timing.milliseconds);
  });
  code(report.next_object_id);
  code(report.mapper_state);
}

/// Where models may grow, at the end of an object; otherwise nothing, as before they could.
template <typename Coder, typename Object>
void VisitScales(Coder& code, Object& object) {
  if constexpr (Coder::kReads) {
    if (code.AtEnd()) return;
  } else {
    if (object.scale == 1 && object.scale_std == 0) return;
  }
  code(object.scale);
  code(object.scale_std);
  for (auto& mode : object.modes) {
    code(mode.scale);
    code(mode.scale_std);
  }
}

template <typename Coder, typename Object>
void VisitObject(Coder& code, Object& object) {
  code(object.reference_frame);
  VisitPose(code, object.world_from_reference_cam);
  code(object.first_frame);
  code(object.last_frame);
  VisitList(code, object.label_probability, [&](auto& entry) {
    code(entry.label.value);
    code(entry.probability);
  });
  VisitPlace(code, object.world_from_object);
  VisitMatrix(code, object.covariance, 4, 4);
  VisitList(code, object.modes, [&](auto& mode) {
    code(mode.label.value);
    code(mode.weight);
    VisitPlace(code, mode.world_from_object);
    code(mode.position_std_m);
    code(mode.azimuth_std_rad);
  });
  code(object.effective_sample_size);
  code(object.log_evidence);
  code(object.visible_fraction);
  code(object.phi_cnn);
  code(object.phi_edge);
  VisitBox(code, object.whole_box);
  VisitBox(code, object.visible_box);
  code(object.filter_state);
  VisitScales(code, object);
}

template <typename Coder, typename Vector>
void VisitVector(Coder& code, Vector& vector) {
  VisitMatrix(code, vector, static_cast<int>(vector.rows()), 1);
}

/// The upper triangle.
template <typename Coder, typename Matrix>
void VisitSymmetric(Coder& code, Matrix& matrix) {
  for (int row = 0; row < matrix.rows(); ++row) {
    for (int column = row; column < matrix.cols(); ++column) {
      code(matrix(row, column));
      if constexpr (Coder::kReads) matrix(column, row) = matrix(row, column);
    }
  }
}

template <typename Coder, typename Report>
void VisitVio(Coder& code, Report& vio) {
  code(vio.stamp_ns);
  code(vio.phase);
  code(vio.message);
  code(vio.stretch);
  code(vio.resting);
  VisitPose(code, vio.world_from_body);
  VisitSymmetric(code, vio.covariance);
  VisitVector(code, vio.velocity_in_world);
  VisitVector(code, vio.gyro_bias);
  VisitVector(code, vio.accel_bias);
  VisitPose(code, vio.body_from_cam);
  code(vio.time_offset_s);
  VisitVector(code, vio.spread);
  code(vio.step.tracks);
  code(vio.step.points);
  code(vio.step.accepted);
  code(vio.step.rejected);
  code(vio.step.nis);
  code(vio.step.nis_dof);
  code(vio.step.propagate_ms);
  code(vio.step.update_ms);
}

/// Where the filter refined the lens, at the end of a report; otherwise nothing, as before it
/// could.
template <typename Coder, typename Report>
void VisitLens(Coder& code, Report& vio) {
  if constexpr (Coder::kReads) {
    if (code.AtEnd()) return;
  } else {
    if (vio.lens_spread.isZero(0)) return;
  }
  VisitVector(code, vio.lens);
  VisitVector(code, vio.lens_spread);
}

template <typename Coder, typename Report>
void VisitOwnPose(Coder& code, Report& report) {
  VisitVio(code, report.vio);
  code(report.measured);
  code(report.ready);
  code(report.waits_for);
  code(report.tilt_std_rad);
  code(report.velocity_std_m_s);
  code(report.nis_gate);
  code(report.tracking_ms);
  VisitOptional(code, report.world_from_cam, [&](auto& pose) { VisitPose(code, pose); });
  VisitSymmetric(code, report.cam_covariance);
  VisitVector(code, report.angular_velocity_rad_s);
  VisitVector(code, report.specific_force_m_s2);
  VisitList(code, report.tracks, [&](auto& track) {
    code(track.id);
    VisitVector(code, track.pixel);
    code(track.age);
    code(track.state);
    code(track.residual_px);
  });
  VisitList(code, report.points_in_world, [&](auto& point) { VisitVector(code, point); });
  VisitOptional(code, report.floor, [&](auto& floor) {
    code(floor.height_m);
    code(floor.std_m);
    code(floor.points);
  });
  VisitLens(code, report.vio);
}

template <typename Coder, typename Node>
void VisitNode(Coder& code, Node& node) {
  code(node.stamp_ns);
  VisitVector(code, node.filter_position_in_world);
  code(node.corrected.yaw_rad);
  VisitVector(code, node.corrected.position_in_world);
}

// Level 1: higher ones gain 1 % on floating-point numbers.
std::string Compress(std::string_view bytes) {
  uLongf size = compressBound(bytes.size());
  const auto length = static_cast<std::uint32_t>(bytes.size());
  std::string out(sizeof(length) + size, '\0');
  std::memcpy(out.data(), &length, sizeof(length));
  const int code = compress2(reinterpret_cast<Bytef*>(out.data() + sizeof(length)), &size,
                             reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), 1);
  PLB_CHECK(code == Z_OK) << "zlib: " << code;
  out.resize(sizeof(length) + size);
  return out;
}

Error Damaged() { return {ErrorCode::kCorrupt, "a frame in it is damaged"}; }

Result<std::string> Decompress(std::string_view bytes) {
  std::uint32_t length = 0;
  if (bytes.size() < sizeof(length)) return Damaged();
  std::memcpy(&length, bytes.data(), sizeof(length));
  bytes.remove_prefix(sizeof(length));
  // zlib packs at most 1032 to 1; a wild length is damage, not a reason to ask for 4 GB.
  if (length > bytes.size() * 1032) return Damaged();
  std::string out(length, '\0');
  uLongf size = length;
  const int code = uncompress(reinterpret_cast<Bytef*>(out.data()), &size,
                              reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  if (code != Z_OK || size != length) return Damaged();
  return out;
}

template <typename Visit>
Status DecodeCompressed(std::string_view bytes, Visit visit) {
  const Result<std::string> plain = Decompress(bytes);
  if (!plain) return plain.error();
  Decoder decoder(*plain);
  visit(decoder);
  if (!decoder.complete()) return Damaged();
  return {};
}

template <typename T>
void AppendPlanes(const std::vector<Particle>& particles, T Particle::*member, std::string& bytes) {
  for (std::size_t plane = 0; plane < sizeof(T); ++plane) {
    for (const Particle& particle : particles) {
      bytes.push_back(reinterpret_cast<const char*>(&(particle.*member))[plane]);
    }
  }
}

template <typename T>
void ReadPlanes(const char*& bytes, T Particle::*member, std::vector<Particle>& particles) {
  for (std::size_t plane = 0; plane < sizeof(T); ++plane) {
    for (Particle& particle : particles) {
      reinterpret_cast<char*>(&(particle.*member))[plane] = *bytes++;
    }
  }
}

template <typename Visit>
void VisitParticleColumns(Visit visit) {
  visit(&Particle::x_c);
  visit(&Particle::y_c);
  visit(&Particle::rho);
  visit(&Particle::azimuth);
  visit(&Particle::log_weight);
  visit(&Particle::phi_cnn);
  visit(&Particle::phi_edge);
  visit(&Particle::label);
  visit(&Particle::ancestor);
}
constexpr std::size_t kBytesPerParticle = 7 * sizeof(float) + 2 * sizeof(std::uint16_t);
static_assert(sizeof(Particle) == kBytesPerParticle + sizeof(float),
              "a new field of Particle needs a column here");
/// Of those that have a scale. One byte follows them: so the length tells which they are.
constexpr std::size_t kBytesPerScaledParticle = kBytesPerParticle + sizeof(float);

}  // namespace

std::string EncodeFrame(const FrameReport& report) {
  Encoder encoder;
  VisitFrame(encoder, report);
  return Compress(encoder.bytes());
}

Status DecodeFrame(std::string_view bytes, FrameReport& report) {
  return DecodeCompressed(bytes, [&](Decoder& decoder) { VisitFrame(decoder, report); });
}

std::string EncodeObject(const ObjectReport& object) {
  Encoder encoder;
  VisitObject(encoder, object);
  return Compress(encoder.bytes());
}

Status DecodeObject(std::string_view bytes, ObjectReport& object) {
  return DecodeCompressed(bytes, [&](Decoder& decoder) { VisitObject(decoder, object); });
}

bool IsState(std::int64_t number) {
  return number >= 0 && number <= static_cast<std::int64_t>(ObjectState::kRetired);
}

bool NamesModels(const ObjectReport& object, int num_models) {
  const auto known = [num_models](const auto& of) {
    return of.label.value >= 0 && of.label.value < num_models;
  };
  return known(object) && std::all_of(object.modes.begin(), object.modes.end(), known) &&
         std::all_of(object.label_probability.begin(), object.label_probability.end(), known);
}

bool NameModels(const std::vector<Particle>& particles, int num_models) {
  return std::all_of(particles.begin(), particles.end(), [num_models](const Particle& particle) {
    return particle.label < num_models;
  });
}

std::string EncodeOwnPose(const OwnPoseReport& report) {
  Encoder encoder;
  VisitOwnPose(encoder, report);
  return Compress(encoder.bytes());
}

Status DecodeOwnPose(std::string_view bytes, OwnPoseReport& report) {
  return DecodeCompressed(bytes, [&](Decoder& decoder) { VisitOwnPose(decoder, report); });
}

std::string EncodeMoves(const PastCorrection& correction) {
  Encoder encoder;
  encoder(correction.present.yaw_rad);
  VisitVector(encoder, correction.present.shift_m);
  VisitList(encoder, correction.past.nodes(),
            [&](const TrajectoryMoves::Node& node) { VisitNode(encoder, node); });
  return Compress(encoder.bytes());
}

Status DecodeMoves(std::string_view bytes, PastCorrection& correction) {
  std::vector<TrajectoryMoves::Node> nodes;
  Status status = DecodeCompressed(bytes, [&](Decoder& decoder) {
    decoder(correction.present.yaw_rad);
    VisitVector(decoder, correction.present.shift_m);
    VisitList(decoder, nodes, [&](TrajectoryMoves::Node& node) { VisitNode(decoder, node); });
    for (std::size_t i = 1; i < nodes.size(); ++i)
      decoder.Require(nodes[i - 1].stamp_ns < nodes[i].stamp_ns);
  });
  correction.past = TrajectoryMoves(std::move(nodes));
  return status;
}

std::string EncodeParticles(const std::vector<Particle>& particles) {
  std::string bytes;
  bytes.reserve(particles.size() * kBytesPerParticle);
  VisitParticleColumns([&](auto member) { AppendPlanes(particles, member, bytes); });
  if (std::any_of(particles.begin(), particles.end(),
                  [](const Particle& particle) { return particle.log_scale != 0; })) {
    AppendPlanes(particles, &Particle::log_scale, bytes);
    bytes.push_back(1);
  }
  return Compress(bytes);
}

Result<std::vector<Particle>> DecodeParticles(std::string_view bytes) {
  const Result<std::string> plain = Decompress(bytes);
  if (!plain) return plain.error();
  const bool scaled = plain->size() % 2 == 1;
  const std::size_t size = plain->size() - (scaled ? 1 : 0);
  const std::size_t each = scaled ? kBytesPerScaledParticle : kBytesPerParticle;
  if (size % each != 0) return Damaged();
  std::vector<Particle> particles(size / each);
  const char* next = plain->data();
  VisitParticleColumns([&](auto member) { ReadPlanes(next, member, particles); });
  if (scaled) ReadPlanes(next, &Particle::log_scale, particles);
  return particles;
}

}  // namespace plumbline
