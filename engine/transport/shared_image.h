// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/transport/plumbline.pb.h"

namespace plumbline {

/// Images that lie in the same memory for all processes of a user on this machine: one copy is made
/// when an image is shared, none when another process maps it. The memory is sealed, so that nobody
/// can change or shorten it, and has no name in any folder: it is gone with the last process that
/// uses it, however that ends.
class SharedImage {
 public:
  /// Copies the rows of an image of 8 bits into shared memory. Errors: kIo.
  static Result<std::shared_ptr<const SharedImage>> Create(const cv::Mat& image);
  ~SharedImage();
  SharedImage(const SharedImage&) = delete;
  SharedImage& operator=(const SharedImage&) = delete;

  /// The shared pixels, for this process; lives on when this does not.
  const cv::Mat& image() const { return image_; }
  /// For another process, as long as this lives.
  wire::SharedMemory name() const;

 private:
  SharedImage() = default;
  int descriptor_ = -1;
  std::uint64_t inode_ = 0, bytes_ = 0;
  cv::Mat image_;
};

/// The image that another process has shared. Whoever writes to it changes a copy of its own.
/// Errors: kNotFound where it is gone (ask its owner again); kCorrupt where it is no sealed memory
/// of that size.
Result<cv::Mat> MapSharedImage(const wire::SharedMemory& name, const cv::Size& size, int type);

/// Names this machine, user and view of its processes: where two programs say the same, one can map
/// what the other shares.
const std::string& ThisMachine();

}  // namespace plumbline
