// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/shared_image.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

namespace plumbline {
namespace {

constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL;

/// Owns the mapping behind a cv::Mat, which counts its uses.
class MappedMemory : public cv::MatAllocator {
 public:
  static cv::Mat Wrap(void* pages, std::size_t bytes, const cv::Size& size, int type) {
    static MappedMemory allocator;
    cv::Mat image(size, type, pages);
    auto* data = new cv::UMatData(&allocator);
    data->data = data->origdata = static_cast<uchar*>(pages);
    data->size = bytes;
    data->refcount = 1;
    image.u = data;
    image.allocator = nullptr;  // what it is resized to is memory like any other
    return image;
  }

  cv::UMatData* allocate(int, const int*, int, void*, std::size_t*, cv::AccessFlag,
                         cv::UMatUsageFlags) const override {
    return nullptr;
  }
  bool allocate(cv::UMatData*, cv::AccessFlag, cv::UMatUsageFlags) const override { return false; }
  void deallocate(cv::UMatData* data) const override {
    ::munmap(data->origdata, data->size);
    delete data;
  }
};

/// Private: a write copies the page it goes to. Writing is allowed only after all pages are there,
/// since a page that comes in for writing would be copied at once.
Result<cv::Mat> MapPages(int descriptor, std::size_t bytes, const cv::Size& size, int type) {
  void* pages = ::mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE | MAP_POPULATE, descriptor, 0);
  if (pages == MAP_FAILED || ::mprotect(pages, bytes, PROT_READ | PROT_WRITE) != 0)
    return Error{ErrorCode::kIo, "cannot map an image of another process"};
  return MappedMemory::Wrap(pages, bytes, size, type);
}

std::string FirstLineOf(const char* file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

}  // namespace

Result<std::shared_ptr<const SharedImage>> SharedImage::Create(const cv::Mat& image) {
  const std::size_t row_bytes = image.cols * image.elemSize();
  const std::size_t bytes = image.rows * row_bytes;
  const Error no_room = {ErrorCode::kIo, "cannot share an image of " + std::to_string(bytes) +
                                             " bytes with other processes: no memory is left"};
  std::shared_ptr<SharedImage> shared(new SharedImage());
  shared->descriptor_ = ::memfd_create("plumbline image", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (shared->descriptor_ < 0 || bytes == 0 ||
      ::ftruncate(shared->descriptor_, static_cast<off_t>(bytes)) != 0)
    return no_room;
  void* pages = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE,
                       shared->descriptor_, 0);
  if (pages == MAP_FAILED) return no_room;
  for (int row = 0; row < image.rows; ++row)
    std::memcpy(static_cast<char*>(pages) + row * row_bytes, image.ptr(row), row_bytes);
  ::munmap(pages, bytes);
  struct stat state {};
  if (::fcntl(shared->descriptor_, F_ADD_SEALS, kSeals) != 0 ||
      ::fstat(shared->descriptor_, &state) != 0)
    return no_room;
  shared->inode_ = state.st_ino;
  shared->bytes_ = bytes;
  Result<cv::Mat> mapped = MapPages(shared->descriptor_, bytes, image.size(), image.type());
  if (!mapped.ok()) return mapped.error();
  shared->image_ = std::move(mapped).value();
  return std::shared_ptr<const SharedImage>(std::move(shared));
}

SharedImage::~SharedImage() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

wire::SharedMemory SharedImage::name() const {
  wire::SharedMemory name;
  name.set_process(::getpid());
  name.set_file(descriptor_);
  name.set_inode(inode_);
  name.set_bytes(bytes_);
  return name;
}

Result<cv::Mat> MapSharedImage(const wire::SharedMemory& name, const cv::Size& size, int type) {
  const std::size_t bytes =
      static_cast<std::size_t>(size.area()) * static_cast<std::size_t>(CV_ELEM_SIZE(type));
  if (name.bytes() != bytes || bytes == 0)
    return Error{ErrorCode::kCorrupt, "a shared image has another size than it says"};
  const Error gone = {ErrorCode::kNotFound, "a shared image is gone"};
  const std::string file =
      "/proc/" + std::to_string(name.process()) + "/fd/" + std::to_string(name.file());
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor < 0) return gone;
  struct stat state {};
  // Whoever sealed it against shrinking cannot make reading it end this program.
  const int seals = ::fcntl(descriptor, F_GET_SEALS);
  Result<cv::Mat> image = gone;
  if (::fstat(descriptor, &state) == 0 && state.st_ino == name.inode()) {
    if (seals < 0 || (seals & kSeals) != kSeals || state.st_size != static_cast<off_t>(bytes)) {
      image = Error{ErrorCode::kCorrupt, "what was told to be a shared image is none"};
    } else {
      image = MapPages(descriptor, bytes, size, type);
    }
  }
  ::close(descriptor);
  return image;
}

const std::string& ThisMachine() {
  static const std::string kName = [] {
    std::error_code error;
    const auto processes = std::filesystem::read_symlink("/proc/self/ns/pid", error);
    return FirstLineOf("/proc/sys/kernel/random/boot_id") + " " + processes.string() + " " +
           std::to_string(::getuid());
  }();
  return kName;
}

}  // namespace plumbline
