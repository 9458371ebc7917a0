// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/models/textured_mesh.h"

namespace plumbline {
namespace {

constexpr int kLargestRegion_px = 4096;  ///< Of a side.
constexpr int kBorder_px = 2;            ///< Around a region, so that nothing bleeds into it.
constexpr int kSpot_px = 4;
constexpr std::uint8_t kPlainGrey = 200;  ///< Of parts without any colour beside coloured ones.

/// A part of the joint image and what of a texture it holds.
struct Region {
  Eigen::AlignedBox2f used;  ///< In texture coordinates.
  cv::Mat image;             ///< With borders.
  int top_px = 0;            ///< In the joint image.
};

Eigen::AlignedBox2f ReachOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox2f reach;
  for (const Eigen::Vector2f& uv : mesh.texture_coordinates) reach.extend(uv);
  return reach;
}

/// The texture over `used`, repeated as often as that needs, and a border around it.
cv::Mat CutOutOf(const cv::Mat& texture, const Eigen::AlignedBox2f& used) {
  const auto texels = [](float span, int size) {
    const double wanted = std::ceil(static_cast<double>(span) * size);
    return std::clamp(wanted, 1.0, static_cast<double>(kLargestRegion_px));
  };
  const int width = static_cast<int>(texels(used.sizes().x(), texture.cols));
  const int height = static_cast<int>(texels(used.sizes().y(), texture.rows));
  // A texture that is shown smaller is made smaller first: single texels would be noise.
  cv::Mat source = texture;
  const double shrink_x = width / (static_cast<double>(used.sizes().x()) * texture.cols + 1e-9);
  const double shrink_y = height / (static_cast<double>(used.sizes().y()) * texture.rows + 1e-9);
  if (shrink_x < 0.99 || shrink_y < 0.99) {
    cv::resize(texture, source,
               {std::max(1, static_cast<int>(texture.cols * std::min(1.0, shrink_x))),
                std::max(1, static_cast<int>(texture.rows * std::min(1.0, shrink_y)))},
               0, 0, cv::INTER_AREA);
  }
  cv::Mat image(height + 2 * kBorder_px, width + 2 * kBorder_px, CV_8UC3);
  for (int y = 0; y < image.rows; ++y) {
    const float down = (static_cast<float>(y - kBorder_px) + 0.5f) / static_cast<float>(height);
    for (int x = 0; x < image.cols; ++x) {
      const float right = (static_cast<float>(x - kBorder_px) + 0.5f) / static_cast<float>(width);
      const Eigen::Vector3f rgb = TexelAt(source, {used.min().x() + right * used.sizes().x(),
                                                   used.max().y() - down * used.sizes().y()});
      for (int c = 0; c < 3; ++c)
        image.at<cv::Vec3b>(y, x)[c] = static_cast<std::uint8_t>(std::lround(rgb[2 - c]));
    }
  }
  return image;
}

/// Into the joint image; a region without a texture is one spot.
void MoveCoordinates(const Region& region, const cv::Size& joint, TriangleMesh& mesh) {
  const float width = static_cast<float>(region.image.cols - 2 * kBorder_px);
  const float height = static_cast<float>(region.image.rows - 2 * kBorder_px);
  for (Eigen::Vector2f& uv : mesh.texture_coordinates) {
    const Eigen::Vector2f share =
        (uv - region.used.min()).cwiseQuotient(region.used.sizes().cwiseMax(1e-9f));
    const float x = kBorder_px + share.x() * width;
    const float y = static_cast<float>(region.top_px + kBorder_px) + (1 - share.y()) * height;
    uv = {x / static_cast<float>(joint.width), 1 - y / static_cast<float>(joint.height)};
  }
}

/// Where one part has colours all need them, else joining drops them.
void GiveAllColors(std::vector<TexturePart>& parts) {
  const bool any = std::any_of(parts.begin(), parts.end(),
                               [](const TexturePart& p) { return !p.mesh.colors.empty(); });
  if (!any) return;
  for (auto& [mesh, texture] : parts) {
    const std::uint8_t level = texture < 0 ? kPlainGrey : 255;
    if (mesh.colors.empty()) mesh.colors.assign(mesh.vertices.size(), {level, level, level});
  }
}

void PlaceInOneTexture(const std::vector<cv::Mat>& textures, std::vector<TexturePart>& parts,
                       cv::Mat& joint) {
  std::map<int, Region> regions;
  for (auto& [mesh, texture] : parts) {
    if (texture < 0) mesh.texture_coordinates.assign(mesh.vertices.size(), {0.5f, 0.5f});
    regions[texture].used.extend(ReachOf(mesh));
  }
  cv::Size size(0, 0);
  for (auto& [texture, region] : regions) {
    if (texture < 0) {
      region.used = {Eigen::Vector2f(0, 0), Eigen::Vector2f(1, 1)};
      region.image = cv::Mat(kSpot_px + 2 * kBorder_px, kSpot_px + 2 * kBorder_px, CV_8UC3,
                             cv::Scalar::all(255));
    } else {
      region.image = CutOutOf(textures[static_cast<std::size_t>(texture)], region.used);
    }
    region.top_px = size.height;
    size.height += region.image.rows;
    size.width = std::max(size.width, region.image.cols);
  }
  joint = cv::Mat(size, CV_8UC3, cv::Scalar::all(255));
  for (const auto& [texture, region] : regions)
    region.image.copyTo(joint(cv::Rect({0, region.top_px}, region.image.size())));
  for (auto& [mesh, texture] : parts) MoveCoordinates(regions[texture], size, mesh);
}

}  // namespace

cv::Mat DecodePicture(std::string bytes) {
  constexpr std::size_t kSignature = 8, kFrame = 12;  // length and name before, checksum behind
  if (bytes.starts_with("\x89PNG")) {
    for (std::size_t at = kSignature; at + kFrame <= bytes.size();) {
      std::size_t length = 0;
      for (std::size_t i = 0; i < 4; ++i)
        length = length << 8 | static_cast<unsigned char>(bytes[at + i]);
      if (length > bytes.size() - at - kFrame) break;
      if (bytes.compare(at + 4, 4, "iCCP") == 0) {
        bytes.erase(at, length + kFrame);
      } else {
        at += length + kFrame;
      }
    }
  }
  if (bytes.empty()) return {};
  try {
    return cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, bytes.data()),
                        cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};  // It claims to be larger than anything that OpenCV reads.
  }
}

Eigen::Vector3f TexelAt(const cv::Mat& texture, const Eigen::Vector2f& coordinates) {
  const auto wrapped = [](int i, int size) { return ((i % size) + size) % size; };
  // Far outside single precision has no fraction left; the whole repeats are of no account.
  const Eigen::Vector2f within = coordinates.array() - coordinates.array().floor();
  const float x = within.x() * static_cast<float>(texture.cols) - 0.5f;
  const float y = (1 - within.y()) * static_cast<float>(texture.rows) - 0.5f;
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  Eigen::Vector3f rgb(0, 0, 0);
  for (int i = 0; i < 4; ++i) {
    const int dx = i % 2, dy = i / 2;
    const float weight = std::abs(1 - dx - (x - static_cast<float>(left))) *
                         std::abs(1 - dy - (y - static_cast<float>(top)));
    const auto& bgr =
        texture.at<cv::Vec3b>(wrapped(top + dy, texture.rows), wrapped(left + dx, texture.cols));
    rgb += weight * Eigen::Vector3f(bgr[2], bgr[1], bgr[0]);
  }
  return rgb;
}

TexturedMesh JoinParts(std::vector<TexturePart> parts, const std::vector<cv::Mat>& textures) {
  TexturedMesh joined;
  const auto same = [&](const TexturePart& part) { return part.texture == parts[0].texture; };
  if (parts.empty()) return joined;
  GiveAllColors(parts);
  if (!std::all_of(parts.begin(), parts.end(), same)) {
    PlaceInOneTexture(textures, parts, joined.texture);
  } else if (parts[0].texture >= 0) {
    joined.texture = textures[static_cast<std::size_t>(parts[0].texture)];
  }
  joined.mesh = std::move(parts[0].mesh);
  for (std::size_t i = 1; i < parts.size(); ++i) Append(parts[i].mesh, joined.mesh);
  return joined;
}

}  // namespace plumbline
