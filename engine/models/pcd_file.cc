// SPDX-License-Identifier: Apache-2.0
#include "engine/models/pcd_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace plumbline {
namespace {

constexpr std::size_t kMostPoints = 1'000'000'000;

struct Field {
  std::string name;
  std::size_t size = 4, count = 1;  ///< Bytes of one value; values.
  char type = 'F';                  ///< I, U or F.
  std::size_t begin = 0;            ///< Byte in a row.
};

struct PcdHeader {
  std::vector<Field> fields;
  std::size_t points = 0, row_size = 0;
  std::string data;
  std::size_t size = 0;  ///< Bytes up to the first value.
};

/// "SIZE 4 4 4" into `values`; what is wrong, or "".
template <typename T>
std::string ReadList(std::istringstream& line, std::vector<T>& values) {
  T value;
  while (line >> value) values.push_back(value);
  return line.eof() ? "" : "a line of its header is no list of numbers";
}

/// What is wrong with the header, or "".
std::string ReadHeader(std::string_view bytes, PcdHeader& header) {
  std::vector<std::string> names;
  std::vector<std::size_t> sizes, counts;
  std::vector<char> types;
  std::size_t width = 0, height = 1;
  bool has_points = false;
  while (header.data.empty()) {
    const std::size_t end = bytes.find('\n', header.size);
    if (end == std::string_view::npos) return "its header has no line DATA";
    std::istringstream line(std::string(bytes.substr(header.size, end - header.size)));
    header.size = end + 1;
    std::string key, wrong;
    if (!(line >> key) || key[0] == '#') continue;
    if (key == "FIELDS" || key == "COLUMNS") wrong = ReadList(line, names);
    if (key == "SIZE") wrong = ReadList(line, sizes);
    if (key == "TYPE") wrong = ReadList(line, types);
    if (key == "COUNT") wrong = ReadList(line, counts);
    if (key == "WIDTH") line >> width;
    if (key == "HEIGHT") line >> height;
    if (key == "POINTS") has_points = static_cast<bool>(line >> header.points);
    if (key == "DATA") line >> header.data;
    if (!wrong.empty()) return wrong;
  }
  if (counts.empty()) counts.assign(names.size(), 1);
  if (sizes.size() != names.size() || types.size() != names.size() ||
      counts.size() != names.size()) {
    return "FIELDS, SIZE, TYPE and COUNT of its header are not of one length";
  }
  if (!has_points) header.points = width * height;
  if (header.points > kMostPoints) return "it claims to hold more points than make sense";
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool known = types[i] == 'F' ? sizes[i] == 4 || sizes[i] == 8
                                       : (types[i] == 'I' || types[i] == 'U') && sizes[i] <= 8 &&
                                             std::has_single_bit(sizes[i]);
    if (!known || counts[i] > 10'000) return "the type of its field '" + names[i] + "' is unknown";
    header.fields.push_back({names[i], sizes[i], counts[i], types[i], header.row_size});
    header.row_size += sizes[i] * counts[i];
  }
  return "";
}

const Field* FieldNamed(const PcdHeader& header, std::string_view name) {
  const auto found = std::find_if(header.fields.begin(), header.fields.end(),
                                  [&](const Field& field) { return field.name == name; });
  return found == header.fields.end() ? nullptr : &*found;
}

/// Marc Lehmann's LZF: a control byte below 32 announces as many literals + 1, another a copy of
/// (its upper 3 bits, 7: and the next byte) + 2 bytes from up to 8191 back. Nothing if it is
/// damaged.
std::optional<std::string> DecompressLzf(std::string_view in, std::size_t size) {
  std::string out;
  out.reserve(size);
  for (std::size_t i = 0; i < in.size();) {
    const auto byte = [&](std::size_t k) { return static_cast<std::uint8_t>(in[k]); };
    const std::size_t control = byte(i++);
    if (control < 32) {
      if (i + control + 1 > in.size() || out.size() + control + 1 > size) return std::nullopt;
      out.append(in.substr(i, control + 1));
      i += control + 1;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) {
      if (i >= in.size()) return std::nullopt;
      length += byte(i++);
    }
    if (i >= in.size()) return std::nullopt;
    const std::size_t back = ((control & 31) << 8 | byte(i++)) + 1;
    length += 2;
    if (back > out.size() || out.size() + length > size) return std::nullopt;
    // Copies may overlap what they write.
    for (std::size_t k = 0; k < length; ++k) out.push_back(out[out.size() - back]);
  }
  if (out.size() != size) return std::nullopt;
  return out;
}

/// Values by field and point, whatever the encoding.
class Values {
 public:
  virtual ~Values() = default;
  virtual double Number(const Field& field, std::size_t point) const = 0;
  /// The 32 bits of a packed colour.
  virtual std::uint32_t Bits(const Field& field, std::size_t point) const = 0;
};

class BinaryValues : public Values {
 public:
  /// @param by_field  All values of a field together, as the compressed encoding has them.
  BinaryValues(std::string_view bytes, const PcdHeader& header, bool by_field)
      : bytes_(bytes), header_(header), by_field_(by_field) {}

  double Number(const Field& field, std::size_t point) const override {
    const char* at = At(field, point);
    if (field.type == 'F') return field.size == 4 ? Read<float>(at) : Read<double>(at);
    const bool is_signed = field.type == 'I';
    switch (field.size) {
      case 1:
        return is_signed ? Read<std::int8_t>(at) : Read<std::uint8_t>(at);
      case 2:
        return is_signed ? Read<std::int16_t>(at) : Read<std::uint16_t>(at);
      case 4:
        return is_signed ? Read<std::int32_t>(at) : Read<std::uint32_t>(at);
      default:
        return is_signed ? static_cast<double>(Read<std::int64_t>(at))
                         : static_cast<double>(Read<std::uint64_t>(at));
    }
  }
  std::uint32_t Bits(const Field& field, std::size_t point) const override {
    return field.size == 4 ? Read<std::uint32_t>(At(field, point)) : 0;
  }

 private:
  template <typename T>
  static T Read(const char* at) {
    static_assert(std::endian::native == std::endian::little);
    T value;
    std::memcpy(&value, at, sizeof(T));
    return value;
  }
  const char* At(const Field& field, std::size_t point) const {
    const std::size_t offset = by_field_
                                   ? field.begin * header_.points + point * field.size * field.count
                                   : point * header_.row_size + field.begin;
    return bytes_.data() + offset;
  }

  std::string_view bytes_;
  const PcdHeader& header_;
  bool by_field_;
};

class TextValues : public Values {
 public:
  /// Nothing if there are fewer numbers than announced.
  static std::optional<TextValues> Parse(std::string_view text, const PcdHeader& header) {
    TextValues values;
    for (const Field& field : header.fields) {
      values.first_.push_back(values.columns_);
      values.columns_ += field.count;
    }
    values.fields_ = &header.fields;
    const char *at = text.data(), *end = text.data() + text.size();
    if (header.points * values.columns_ > text.size()) return std::nullopt;
    values.numbers_.reserve(header.points * values.columns_);
    while (values.numbers_.size() < header.points * values.columns_) {
      while (at != end && std::isspace(static_cast<unsigned char>(*at)) != 0) ++at;
      double number = 0;
      const auto [next, error] = std::from_chars(at, end, number);
      if (error != std::errc()) return std::nullopt;
      at = next;
      values.numbers_.push_back(number);
    }
    return values;
  }

  double Number(const Field& field, std::size_t point) const override {
    const auto i = static_cast<std::size_t>(&field - fields_->data());
    return numbers_[point * columns_ + first_[i]];
  }
  std::uint32_t Bits(const Field& field, std::size_t point) const override {
    const double number = Number(field, point);
    if (field.type == 'F') return std::bit_cast<std::uint32_t>(static_cast<float>(number));
    return number >= 0 && number < 4294967296.0 ? static_cast<std::uint32_t>(number) : 0;
  }

 private:
  const std::vector<Field>* fields_ = nullptr;
  std::vector<std::size_t> first_;
  std::size_t columns_ = 0;
  std::vector<double> numbers_;
};

/// The three fields, or nothing.
std::optional<std::array<const Field*, 3>> Triple(const PcdHeader& header, const char* x,
                                                  const char* y, const char* z) {
  const std::array<const Field*, 3> fields = {FieldNamed(header, x), FieldNamed(header, y),
                                              FieldNamed(header, z)};
  if (!fields[0] || !fields[1] || !fields[2]) return std::nullopt;
  return fields;
}

TriangleMesh ToCloud(const PcdHeader& header, const std::array<const Field*, 3>& position,
                     const Values& values) {
  const auto normal = Triple(header, "normal_x", "normal_y", "normal_z");
  const Field* color = FieldNamed(header, "rgb");
  if (!color) color = FieldNamed(header, "rgba");
  TriangleMesh cloud;
  const auto vector = [&](const std::array<const Field*, 3>& fields, std::size_t i) {
    return Eigen::Vector3f(static_cast<float>(values.Number(*fields[0], i)),
                           static_cast<float>(values.Number(*fields[1], i)),
                           static_cast<float>(values.Number(*fields[2], i)));
  };
  for (std::size_t i = 0; i < header.points; ++i) {
    const Eigen::Vector3f point = vector(position, i);
    if (!point.allFinite()) continue;
    cloud.vertices.push_back(point);
    if (normal) {
      const Eigen::Vector3f read = vector(*normal, i);
      cloud.normals.push_back(read.allFinite() ? read : Eigen::Vector3f::Zero());
    }
    if (!color) continue;
    const std::uint32_t rgb = values.Bits(*color, i);
    cloud.colors.push_back({static_cast<std::uint8_t>(rgb >> 16 & 255),
                            static_cast<std::uint8_t>(rgb >> 8 & 255),
                            static_cast<std::uint8_t>(rgb & 255)});
  }
  return cloud;
}

}  // namespace

Result<TriangleMesh> ParsePcd(std::string_view bytes, const std::filesystem::path& file,
                              std::size_t* num_left_out) {
  const auto corrupt = [&file](const std::string& what) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' is damaged: " + what};
  };
  PcdHeader header;
  if (const std::string wrong = ReadHeader(bytes, header); !wrong.empty()) return corrupt(wrong);
  const auto position = Triple(header, "x", "y", "z");
  if (!position) return corrupt("it has no fields x, y and z");
  std::string_view body = bytes.substr(header.size);
  const std::size_t size = header.points * header.row_size;
  TriangleMesh cloud;
  if (header.data == "ascii") {
    const auto values = TextValues::Parse(body, header);
    if (!values) return corrupt("it ends before its last point, or a value is no number");
    cloud = ToCloud(header, *position, *values);
  } else if (header.data == "binary") {
    if (body.size() < size) return corrupt("it ends before its last point");
    cloud = ToCloud(header, *position, BinaryValues(body, header, false));
  } else if (header.data == "binary_compressed") {
    std::uint32_t packed = 0, unpacked = 0;
    if (body.size() < 8) return corrupt("it ends before its first point");
    std::memcpy(&packed, body.data(), 4);
    std::memcpy(&unpacked, body.data() + 4, 4);
    body.remove_prefix(8);
    if (body.size() < packed || unpacked != size) return corrupt("it ends before its last point");
    const auto values = DecompressLzf(body.substr(0, packed), size);
    if (!values) return corrupt("its compressed points cannot be unpacked");
    cloud = ToCloud(header, *position, BinaryValues(*values, header, true));
  } else {
    return Error{ErrorCode::kUnsupported, "'" + file.string() + "' holds data '" + header.data +
                                              "'; save it as ascii, binary or binary_compressed"};
  }
  if (cloud.vertices.empty()) return corrupt("it holds no points");
  if (num_left_out != nullptr) *num_left_out = header.points - cloud.vertices.size();
  return cloud;
}

}  // namespace plumbline
