// SPDX-License-Identifier: Apache-2.0
#include "engine/models/ply_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "engine/base/log.h"

namespace plumbline {
namespace {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };
enum class Encoding { kAscii, kLittleEndian, kBigEndian };

struct Property {
  std::string name;
  Type type = Type::kFloat32;
  std::optional<Type> list_count;  ///< Type of the length; nothing for a scalar.
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct PlyHeader {
  Encoding encoding = Encoding::kAscii;
  std::vector<Element> elements;
  std::string texture_file;
  std::size_t size = 0;  ///< Bytes up to the first value.
};

std::optional<Type> TypeNamed(const std::string& name) {
  static constexpr std::array<const char*, 8> kOld = {"char", "uchar", "short", "ushort",
                                                      "int",  "uint",  "float", "double"};
  static constexpr std::array<const char*, 8> kNew = {"int8",  "uint8",  "int16",   "uint16",
                                                      "int32", "uint32", "float32", "float64"};
  for (std::size_t i = 0; i < kOld.size(); ++i) {
    if (name == kOld[i] || name == kNew[i]) return static_cast<Type>(i);
  }
  return std::nullopt;
}

bool IsInteger(Type type) { return type < Type::kFloat32; }

/// The values of a binary body, one after the other.
template <bool kSwap>
class BinarySource {
 public:
  explicit BinarySource(std::string_view bytes) : bytes_(bytes) {}
  std::size_t remaining() const { return bytes_.size(); }
  bool Next(Type type, double& value) {
    switch (type) {
      case Type::kInt8:
        return Read<std::int8_t>(value);
      case Type::kUint8:
        return Read<std::uint8_t>(value);
      case Type::kInt16:
        return Read<std::int16_t>(value);
      case Type::kUint16:
        return Read<std::uint16_t>(value);
      case Type::kInt32:
        return Read<std::int32_t>(value);
      case Type::kUint32:
        return Read<std::uint32_t>(value);
      case Type::kFloat32:
        return Read<float>(value);
      case Type::kFloat64:
        return Read<double>(value);
    }
    return false;
  }

 private:
  template <typename T>
  bool Read(double& value) {
    if (bytes_.size() < sizeof(T)) return false;
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data(), sizeof(T));
    if constexpr (kSwap) std::reverse(raw.begin(), raw.end());
    value = static_cast<double>(std::bit_cast<T>(raw));
    bytes_.remove_prefix(sizeof(T));
    return true;
  }
  std::string_view bytes_;
};

/// The values of an ascii body.
class TextSource {
 public:
  explicit TextSource(std::string_view text) : text_(text) {}
  std::size_t remaining() const { return text_.size(); }
  bool Next(Type /*type*/, double& value) {
    std::size_t start = 0;
    while (start < text_.size() && static_cast<unsigned char>(text_[start]) <= ' ') ++start;
    if (start < text_.size() && text_[start] == '+') ++start;
    text_.remove_prefix(start);
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
    if (error == std::errc::invalid_argument) return false;
    if (error == std::errc::result_out_of_range) value = 0;  // a denormal
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    return true;
  }

 private:
  std::string_view text_;
};

Error Corrupt(const std::filesystem::path& file, const std::string& what) {
  return {ErrorCode::kCorrupt, "'" + file.string() + "' is damaged: " + what};
}

/// One line of the header into `header`; the text of the problem if it makes no sense.
std::optional<std::string> ParseHeaderLine(const std::string& line, PlyHeader& header,
                                           bool& has_format) {
  std::istringstream words(line);
  std::string keyword;
  words >> keyword;
  if (keyword == "format") {
    std::string name;
    words >> name;
    has_format = true;
    if (name == "ascii")
      header.encoding = Encoding::kAscii;
    else if (name == "binary_little_endian")
      header.encoding = Encoding::kLittleEndian;
    else if (name == "binary_big_endian")
      header.encoding = Encoding::kBigEndian;
    else
      return "unknown format '" + name + "'";
  } else if (keyword == "comment") {
    std::string name;
    words >> name;
    if (name == "TextureFile" || name == "texturefile")
      std::getline(words >> std::ws, header.texture_file);
  } else if (keyword == "element") {
    Element element;
    if (!(words >> element.name >> element.count)) return "bad line '" + line + "'";
    header.elements.push_back(element);
  } else if (keyword == "property") {
    std::string type_name;
    words >> type_name;
    Property property;
    if (type_name == "list") {
      std::string count_name;
      words >> count_name >> type_name;
      property.list_count = TypeNamed(count_name);
      if (!property.list_count || !IsInteger(*property.list_count))
        return "bad line '" + line + "'";
    }
    const std::optional<Type> type = TypeNamed(type_name);
    if (!type || !(words >> property.name) || header.elements.empty())
      return "bad line '" + line + "'";
    property.type = *type;
    header.elements.back().properties.push_back(property);
  }
  return std::nullopt;
}

Result<PlyHeader> ParseHeader(std::string_view bytes, const std::filesystem::path& file) {
  PlyHeader header;
  bool has_format = false;
  for (int number = 0;; ++number) {
    const std::size_t end = bytes.find('\n', header.size);
    if (end == std::string_view::npos) return Corrupt(file, "its header has no 'end_header'");
    std::string line(bytes.substr(header.size, end - header.size));
    if (!line.empty() && line.back() == '\r') line.pop_back();
    header.size = end + 1;
    if (number == 0) {
      if (line != "ply") return Corrupt(file, "it does not begin with 'ply'");
    } else if (line == "end_header") {
      if (!has_format) return Corrupt(file, "its header names no format");
      return header;
    } else if (const auto problem = ParseHeaderLine(line, header, has_format)) {
      return Corrupt(file, *problem);
    }
  }
}

/// Where the values of a vertex row are: indices into its properties.
struct VertexLayout {
  std::optional<std::array<std::size_t, 3>> position, normal, color;
  std::optional<std::array<std::size_t, 2>> texture;
};

std::optional<std::size_t> IndexOf(const Element& element, std::string_view name) {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    if (element.properties[i].name == name && !element.properties[i].list_count) return i;
  }
  return std::nullopt;
}

template <std::size_t N>
std::optional<std::array<std::size_t, N>> IndicesOf(const Element& element,
                                                    const std::array<const char*, N>& names) {
  std::array<std::size_t, N> indices;
  for (std::size_t i = 0; i < N; ++i) {
    const std::optional<std::size_t> index = IndexOf(element, names[i]);
    if (!index) return std::nullopt;
    indices[i] = *index;
  }
  return indices;
}

VertexLayout LayoutOf(const Element& element) {
  VertexLayout layout;
  layout.position = IndicesOf<3>(element, {"x", "y", "z"});
  layout.normal = IndicesOf<3>(element, {"nx", "ny", "nz"});
  layout.color = IndicesOf<3>(element, {"red", "green", "blue"});
  if (!layout.color)
    layout.color = IndicesOf<3>(element, {"diffuse_red", "diffuse_green", "diffuse_blue"});
  layout.texture = IndicesOf<2>(element, {"s", "t"});
  if (!layout.texture) layout.texture = IndicesOf<2>(element, {"u", "v"});
  if (!layout.texture) layout.texture = IndicesOf<2>(element, {"texture_u", "texture_v"});
  return layout;
}

std::uint8_t ColorLevel(double value, Type type) {
  if (!IsInteger(type)) value *= 255.0;
  if (type == Type::kUint16) value /= 257.0;
  return static_cast<std::uint8_t>(
      std::clamp(std::isfinite(value) ? std::lround(value) : 0L, 0L, 255L));
}

/// Reads one row: scalars into `row`, the lists' values to nowhere except that of property
/// `kept_list` into `list`.
template <typename Source>
bool ReadRow(Source& source, const Element& element, std::size_t kept_list,
             std::vector<double>& row, std::vector<double>& list) {
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    const Property& property = element.properties[p];
    if (!property.list_count) {
      if (!source.Next(property.type, row[p])) return false;
      continue;
    }
    double count = 0;
    if (!source.Next(*property.list_count, count)) return false;
    if (!(count >= 0) || count > static_cast<double>(source.remaining())) return false;
    if (p == kept_list) list.resize(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      double value = 0;
      if (!source.Next(property.type, value)) return false;
      if (p == kept_list) list[i] = value;
    }
  }
  return true;
}

/// @param is_cloud  Nothing refers to a vertex by its number, so that it may be left out.
template <typename Source>
std::optional<std::string> ReadVertices(Source& source, const Element& element, bool is_cloud,
                                        TriangleMesh& mesh, std::vector<int>* labels) {
  const VertexLayout layout = LayoutOf(element);
  const std::optional<std::size_t> label =
      labels == nullptr ? std::nullopt : IndexOf(element, "label");
  if (!layout.position) return "its vertices have no x, y and z";
  const std::size_t room = std::min(element.count, source.remaining());
  mesh.vertices.reserve(room);
  if (layout.normal) mesh.normals.reserve(room);
  if (layout.color) mesh.colors.reserve(room);
  if (layout.texture) mesh.texture_coordinates.reserve(room);
  std::vector<double> row(element.properties.size(), 0.0), unused;
  const auto vector = [&row](const std::array<std::size_t, 3>& at) {
    return Eigen::Vector3d(row[at[0]], row[at[1]], row[at[2]]).cast<float>().eval();
  };
  for (std::size_t i = 0; i < element.count; ++i) {
    if (!ReadRow(source, element, element.properties.size(), row, unused)) {
      return "it ends within vertex " + std::to_string(i) + " of " + std::to_string(element.count);
    }
    const Eigen::Vector3f point = vector(*layout.position);
    if (!point.allFinite()) {
      if (is_cloud) continue;
      return "vertex " + std::to_string(i) + " is not finite";
    }
    mesh.vertices.push_back(point);
    if (label) {
      const double value = row[*label];
      labels->push_back(std::abs(value) < 1e9 ? static_cast<int>(value) : -1);
    }
    if (layout.normal) mesh.normals.push_back(vector(*layout.normal));
    if (layout.color) {
      std::array<std::uint8_t, 3> color;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t at = (*layout.color)[c];
        color[c] = ColorLevel(row[at], element.properties[at].type);
      }
      mesh.colors.push_back(color);
    }
    if (layout.texture) {
      mesh.texture_coordinates.push_back(
          Eigen::Vector2d(row[(*layout.texture)[0]], row[(*layout.texture)[1]]).cast<float>());
    }
  }
  return std::nullopt;
}

template <typename Source>
std::optional<std::string> ReadFaces(Source& source, const Element& element, TriangleMesh& mesh) {
  std::size_t indices = element.properties.size();
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    const Property& property = element.properties[p];
    if (property.list_count &&
        (property.name == "vertex_indices" || property.name == "vertex_index"))
      indices = p;
  }
  if (indices == element.properties.size()) return "its faces have no vertex_indices";
  if (!IsInteger(element.properties[indices].type)) return "its vertex_indices are not integers";
  mesh.triangles.reserve(std::min(element.count, source.remaining()));
  std::vector<double> row(element.properties.size(), 0.0), corners;
  for (std::size_t i = 0; i < element.count; ++i) {
    if (!ReadRow(source, element, indices, row, corners)) {
      return "it ends within face " + std::to_string(i) + " of " + std::to_string(element.count);
    }
    for (const double corner : corners) {
      if (!(corner >= 0) || corner >= static_cast<double>(mesh.vertices.size()) ||
          corner != std::floor(corner)) {
        return fmt::format("face {} names vertex {:.17g} of {}", i, corner, mesh.vertices.size());
      }
    }
    for (std::size_t k = 2; k < corners.size(); ++k) {
      mesh.triangles.emplace_back(static_cast<int>(corners[0]), static_cast<int>(corners[k - 1]),
                                  static_cast<int>(corners[k]));
    }
  }
  return std::nullopt;
}

std::size_t CountOf(const PlyHeader& header, std::string_view element) {
  std::size_t count = 0;
  for (const Element& other : header.elements) {
    if (other.name == element) count += other.count;
  }
  return count;
}

template <typename Source>
std::optional<std::string> ReadBody(Source source, const PlyHeader& header, TriangleMesh& mesh,
                                    std::vector<int>* labels) {
  const bool is_cloud = CountOf(header, "face") == 0;
  for (const Element& element : header.elements) {
    std::optional<std::string> problem;
    if (element.name == "vertex") {
      problem = ReadVertices(source, element, is_cloud, mesh, labels);
    } else if (element.name == "face" && element.count > 0) {
      problem = ReadFaces(source, element, mesh);
    } else {
      std::vector<double> row(element.properties.size(), 0.0), unused;
      for (std::size_t i = 0; i < element.count && !problem; ++i) {
        if (!ReadRow(source, element, element.properties.size(), row, unused)) {
          problem = "it ends within element '" + element.name + "'";
        }
      }
    }
    if (problem) return problem;
  }
  return std::nullopt;
}

std::optional<std::string> ReadBody(std::string_view body, const PlyHeader& header,
                                    TriangleMesh& mesh, std::vector<int>* labels) {
  constexpr bool kLittleHost = std::endian::native == std::endian::little;
  switch (header.encoding) {
    case Encoding::kAscii:
      return ReadBody(TextSource(body), header, mesh, labels);
    case Encoding::kLittleEndian:
      return ReadBody(BinarySource<!kLittleHost>(body), header, mesh, labels);
    case Encoding::kBigEndian:
      return ReadBody(BinarySource<kLittleHost>(body), header, mesh, labels);
  }
  return "unknown format";
}

}  // namespace

Result<TriangleMesh> ParsePly(std::string_view bytes, const std::filesystem::path& file,
                              std::size_t* num_left_out, std::vector<int>* labels) {
  Result<PlyHeader> header = ParseHeader(bytes, file);
  if (!header.ok()) return header.error();
  for (const Element& element : header->elements) {
    if (element.name == "tristrips" && element.count > 0) {
      return Error{ErrorCode::kUnsupported,
                   "'" + file.string() +
                       "' holds triangle strips; export it with plain faces (MeshLab does)"};
    }
    if (element.properties.empty() && element.count > 0) {
      return Corrupt(file, "element '" + element.name + "' has no properties");
    }
  }
  TriangleMesh mesh;
  if (const auto problem = ReadBody(bytes.substr(header->size), *header, mesh, labels))
    return Corrupt(file, *problem);
  if (mesh.vertices.empty()) return Corrupt(file, "it holds no vertices");
  if (num_left_out != nullptr) *num_left_out = CountOf(*header, "vertex") - mesh.vertices.size();
  if (!std::all_of(mesh.normals.begin(), mesh.normals.end(),
                   [](const auto& n) { return n.allFinite(); })) {
    log::warn("'{}': some normals are not finite; normals are left out", file.string());
    mesh.normals.clear();
  }
  if (!mesh.texture_coordinates.empty()) mesh.texture_file = header->texture_file;
  return mesh;
}

}  // namespace plumbline
