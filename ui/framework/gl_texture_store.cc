// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/gl_texture_store.h"

#include <epoxy/gl.h>

namespace plumbline {

GlTextureStore::~GlTextureStore() {
  for (const auto& [name, entry] : entries_) glDeleteTextures(1, &entry.texture);
}

ImTextureID GlTextureStore::Get(std::string_view name, std::uint64_t version,
                                const std::function<cv::Mat()>& make) {
  auto found = entries_.find(name);
  const bool is_new = found == entries_.end();
  if (is_new) found = entries_.emplace(std::string(name), Entry{}).first;
  Entry& entry = found->second;
  const auto id = [&] {
    return reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(entry.texture));
  };
  if (!is_new && entry.version == version) return id();
  entry.version = version;
  cv::Mat picture = make();
  if (picture.empty()) picture = cv::Mat(1, 1, CV_8UC3, cv::Scalar(18, 15, 13));
  if (is_new) {
    glGenTextures(1, &entry.texture);
    glBindTexture(GL_TEXTURE_2D, entry.texture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  glBindTexture(GL_TEXTURE_2D, entry.texture);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, static_cast<GLint>(picture.step / picture.elemSize()));
  if (picture.cols == entry.width && picture.rows == entry.height) {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, picture.cols, picture.rows, GL_BGR, GL_UNSIGNED_BYTE,
                    picture.data);
  } else {
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture.cols, picture.rows, 0, GL_BGR, GL_UNSIGNED_BYTE,
                 picture.data);
    entry.width = picture.cols;
    entry.height = picture.rows;
  }
  glGenerateMipmap(GL_TEXTURE_2D);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  return id();
}

}  // namespace plumbline
