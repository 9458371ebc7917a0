// SPDX-License-Identifier: Apache-2.0
#include "tests/support/failing_vfs.h"

#include <sqlite3.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace plumbline {
namespace {

sqlite3_vfs* real = nullptr;
sqlite3_vfs shim;
DiskFailure wanted = DiskFailure::kEndBefore;
int wanted_at = 0;
std::atomic<int> count = 0;

/// The real file follows in the same memory.
struct ShimFile {
  sqlite3_file base;
  sqlite3_file* real_file;
};
sqlite3_file* RealOf(sqlite3_file* file) { return reinterpret_cast<ShimFile*>(file)->real_file; }
const sqlite3_io_methods& MethodsOf(sqlite3_file* file) { return *RealOf(file)->pMethods; }

/// Does a change, or what is wanted instead.
template <typename Change, typename Half>
int Count(const Change& change, const Half& half) {
  const int number = ++count;
  if (number < wanted_at) return change();
  if (wanted == DiskFailure::kFailFromThen) return SQLITE_FULL;
  if (number == wanted_at) {
    if (wanted == DiskFailure::kEndHalfWay) half();
    if (wanted == DiskFailure::kEndAfter) change();
  }
  _exit(kEndedByVfs);
}
template <typename Change>
int Count(const Change& change) {
  return Count(change, [] {});
}

int Close(sqlite3_file* file) { return MethodsOf(file).xClose(RealOf(file)); }
int Read(sqlite3_file* file, void* bytes, int size, sqlite3_int64 at) {
  return MethodsOf(file).xRead(RealOf(file), bytes, size, at);
}
int Write(sqlite3_file* file, const void* bytes, int size, sqlite3_int64 at) {
  const auto write = [&](int part) {
    return MethodsOf(file).xWrite(RealOf(file), bytes, part, at);
  };
  return Count([&] { return write(size); }, [&] { write(size / 2); });
}
int Truncate(sqlite3_file* file, sqlite3_int64 size) {
  return Count([&] { return MethodsOf(file).xTruncate(RealOf(file), size); });
}
int Sync(sqlite3_file*, int) {
  return Count([] { return SQLITE_OK; });  // only a power cut would tell, and it takes long
}
int FileSize(sqlite3_file* file, sqlite3_int64* size) {
  return MethodsOf(file).xFileSize(RealOf(file), size);
}
int Lock(sqlite3_file* file, int lock) { return MethodsOf(file).xLock(RealOf(file), lock); }
int Unlock(sqlite3_file* file, int lock) { return MethodsOf(file).xUnlock(RealOf(file), lock); }
int CheckReservedLock(sqlite3_file* file, int* result) {
  return MethodsOf(file).xCheckReservedLock(RealOf(file), result);
}
int FileControl(sqlite3_file* file, int what, void* argument) {
  return MethodsOf(file).xFileControl(RealOf(file), what, argument);
}
int SectorSize(sqlite3_file* file) { return MethodsOf(file).xSectorSize(RealOf(file)); }
int Characteristics(sqlite3_file* file) {
  return MethodsOf(file).xDeviceCharacteristics(RealOf(file));
}
int ShmMap(sqlite3_file* file, int page, int size, int extend, void volatile** memory) {
  return MethodsOf(file).xShmMap(RealOf(file), page, size, extend, memory);
}
int ShmLock(sqlite3_file* file, int offset, int n, int flags) {
  return MethodsOf(file).xShmLock(RealOf(file), offset, n, flags);
}
void ShmBarrier(sqlite3_file* file) { MethodsOf(file).xShmBarrier(RealOf(file)); }
int ShmUnmap(sqlite3_file* file, int remove) {
  return MethodsOf(file).xShmUnmap(RealOf(file), remove);
}

constexpr sqlite3_io_methods kMethods = {2,
                                         Close,
                                         Read,
                                         Write,
                                         Truncate,
                                         Sync,
                                         FileSize,
                                         Lock,
                                         Unlock,
                                         CheckReservedLock,
                                         FileControl,
                                         SectorSize,
                                         Characteristics,
                                         ShmMap,
                                         ShmLock,
                                         ShmBarrier,
                                         ShmUnmap,
                                         nullptr,
                                         nullptr};

int Open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  auto* shim_file = new (file) ShimFile{};
  shim_file->real_file =
      reinterpret_cast<sqlite3_file*>(reinterpret_cast<char*>(file) + sizeof(ShimFile));
  const int code = real->xOpen(real, name, shim_file->real_file, flags, out_flags);
  if (shim_file->real_file->pMethods != nullptr) shim_file->base.pMethods = &kMethods;
  return code;
}
int Delete(sqlite3_vfs*, const char* name, int) {
  return Count([&] { return real->xDelete(real, name, 0); });
}

}  // namespace

void InstallFailingVfs(DiskFailure failure, int at) {
  wanted = failure;
  wanted_at = at;
  count = 0;
  if (real != nullptr) return;
  real = sqlite3_vfs_find(nullptr);
  shim = *real;
  shim.szOsFile += static_cast<int>(sizeof(ShimFile));
  shim.zName = "failing";
  shim.xOpen = Open;
  shim.xDelete = Delete;
  // The other functions only pass their first argument on to what they read from `pAppData`, which
  // is a copy of the real one's.
  if (sqlite3_vfs_register(&shim, 1) != SQLITE_OK) std::abort();
}

int NumDiskChanges() { return count; }

}  // namespace plumbline
