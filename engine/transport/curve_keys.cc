// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/curve_keys.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>

#include "engine/base/data_paths.h"
#include "engine/base/files.h"

namespace plumbline {
namespace {

constexpr std::size_t kKeyLength = 40;
using KeyText = std::array<char, kKeyLength + 1>;

/// A key as its file has it, a line.
Result<std::string> ReadCurveKey(const std::filesystem::path& file) {
  Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text;
  while (!text->empty() && (text->back() == '\n' || text->back() == '\r')) text->pop_back();
  std::array<std::uint8_t, 32> bytes{};
  if (text->size() != kKeyLength || zmq_z85_decode(bytes.data(), text->c_str()) == nullptr) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() +
                                          "' is not a key (40 characters of Z85); make it anew "
                                          "with 'plumbline keys'"};
  }
  return text;
}

/// Never readable by others, not even for a moment; never over one that is there.
Status WriteNewFile(const std::filesystem::path& file, const std::string& line, mode_t mode) {
  const int descriptor =
      ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
  if (descriptor < 0) {
    return Error{errno == EEXIST ? ErrorCode::kInvalidInput : ErrorCode::kIo,
                 "cannot make '" + file.string() +
                     (errno == EEXIST ? "': it is there already; remove it to make another"
                                      : "'; check the folder")};
  }
  const std::string text = line + "\n";
  const bool written =
      ::write(descriptor, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const bool closed = ::fsync(descriptor) == 0 && ::close(descriptor) == 0;
  if (written && closed) return {};
  return Error{ErrorCode::kIo, "cannot write '" + file.string() + "'"};
}

}  // namespace

Status MakeCurveKeys(const std::filesystem::path& folder, const std::string& name) {
  if (!IsFileName(name)) return InvalidInput("'" + name + "' is no name of a node");
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  KeyText public_key{}, secret_key{};
  if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0)
    return Error{ErrorCode::kUnsupported, "this ZeroMQ was built without encryption (CURVE)"};
  Status status = WriteNewFile(folder / (name + ".secret"), secret_key.data(), S_IRUSR | S_IWUSR);
  if (!status.ok()) return status;
  return WriteNewFile(folder / (name + ".public"), public_key.data(), 0644);
}

Result<CurveKeys> ReadCurveKeys(const std::filesystem::path& folder, const std::string& name) {
  CurveKeys keys;
  keys.own_name = name;
  const std::filesystem::path secret = folder / (name + ".secret");
  struct stat state {};
  if (::stat(secret.c_str(), &state) != 0) {
    return Error{ErrorCode::kNotFound, "'" + secret.string() +
                                           "' is not there; make it with 'plumbline keys " + name +
                                           " --out " + folder.string() + "'"};
  }
  if ((state.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    return Error{ErrorCode::kInvalidInput, "'" + secret.string() +
                                               "' can be read by others; make it anew, or allow "
                                               "only its owner to (chmod 600)"};
  }
  Result<std::string> own = ReadCurveKey(secret);
  if (!own.ok()) return own.error();
  keys.own_secret = std::move(own).value();
  KeyText own_public{};
  if (zmq_curve_public(own_public.data(), keys.own_secret.c_str()) != 0)
    return Error{ErrorCode::kUnsupported, "this ZeroMQ was built without encryption (CURVE)"};
  keys.own_public = own_public.data();
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() != ".public") continue;
    Result<std::string> key = ReadCurveKey(entry.path());
    if (!key.ok()) return key.error();
    keys.public_of[entry.path().stem().string()] = std::move(key).value();
  }
  keys.public_of[name] = keys.own_public;
  return keys;
}

}  // namespace plumbline
