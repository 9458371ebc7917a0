// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>

#include "engine/base/timer.h"

namespace plumbline {
namespace {

constexpr int kLookEveryMs = 50;
constexpr double kGraceS = 10;

/// What a shell leaves as it is.
bool IsPlain(const std::string& word) {
  return !word.empty() && word.find_first_not_of(
                              "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                              "_-+=.,:/@%") == std::string::npos;
}

/// The child's side of fork: calls nothing but what is safe after it. What went wrong is written to
/// `failed`, which closes by itself where the program starts.
void BecomeProgram(char* const* argv, const ChildPlace& place, int output, int failed,
                   pid_t parent) {
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int nothing = ::open("/dev/null", O_RDONLY);
  // A parent that was killed meanwhile sends no signal.
  const bool ready = ::getppid() == parent && nothing >= 0 && ::dup2(nothing, 0) == 0 &&
                     ::dup2(output, 1) == 1 && ::dup2(output, 2) == 2 &&
                     ::chdir(place.folder.c_str()) == 0;
  if (ready) ::execvp(argv[0], argv);
  const int why = errno;
  [[maybe_unused]] const auto written = ::write(failed, &why, sizeof(why));
  ::kill(::getpid(), SIGKILL);
}

/// Starts it; its number.
Result<pid_t> StartChild(const std::vector<std::string>& words, const ChildPlace& place) {
  std::vector<std::string> copies = words;
  std::vector<char*> argv;
  for (std::string& word : copies) argv.push_back(word.data());
  argv.push_back(nullptr);
  int failed[2] = {-1, -1};
  const int output = ::open(place.output.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (output < 0) return Error{ErrorCode::kIo, "cannot write '" + place.output.string() + "'"};
  const pid_t parent = ::getpid();
  pid_t process = ::pipe2(failed, O_CLOEXEC) == 0 ? ::fork() : -1;
  if (process == 0) BecomeProgram(argv.data(), place, output, failed[1], parent);
  int why = errno;
  ::close(output);
  ::close(failed[1]);
  if (process > 0) {
    ::setpgid(process, process);  // as the child does; whoever is first
    ssize_t size = 0;
    while ((size = ::read(failed[0], &why, sizeof(why))) < 0 && errno == EINTR) continue;
    if (size == sizeof(why)) {
      ::waitpid(process, nullptr, 0);
      process = -1;
    }
  }
  ::close(failed[0]);
  if (process > 0) return process;
  return Error{ErrorCode::kIo, "cannot start '" + words[0] + "': " + std::strerror(why)};
}

/// Of a child that may be waited for.
class Child {
 public:
  explicit Child(pid_t process)
      : process_(process), handle_(static_cast<int>(syscall(SYS_pidfd_open, process, 0))) {}
  ~Child() {
    if (handle_ >= 0) ::close(handle_);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Waits a little; true when it has ended.
  bool Ended(int& status) const {
    pollfd waited{handle_, POLLIN, 0};
    ::poll(&waited, handle_ >= 0 ? 1 : 0, kLookEveryMs);
    return ::waitpid(process_, &status, WNOHANG) == process_;
  }
  void Signal(int signal) const { ::kill(-process_, signal); }

 private:
  pid_t process_;
  int handle_;
};

}  // namespace

Result<ChildEnd> RunChild(const std::vector<std::string>& words, const ChildPlace& place,
                          const std::stop_token& stop) {
  const Result<pid_t> process = StartChild(words, place);
  if (!process.ok()) return process.error();
  const Child child(*process);
  ChildEnd end;
  Stopwatch watch;
  std::optional<double> asked_s;
  int status = 0;
  while (!child.Ended(status)) {
    const double now_s = watch.Milliseconds() / 1000;
    end.timed_out |= place.timeout_s && now_s > *place.timeout_s;
    if (!asked_s && (end.timed_out || stop.stop_requested())) {
      asked_s = now_s;
      child.Signal(SIGTERM);
    }
    if (asked_s && now_s > *asked_s + kGraceS) child.Signal(SIGKILL);
  }
  if (asked_s) child.Signal(SIGKILL);  // whatever it started and left behind
  if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  if (WIFEXITED(status)) end.exit_code = WEXITSTATUS(status);
  return end;
}

std::string InWords(const ChildEnd& end) {
  if (end.timed_out) return "took too long";
  if (end.signal != 0)
    return "was ended by signal " + std::to_string(end.signal) + " (" + ::strsignal(end.signal) +
           ")";
  return "ended with exit code " + std::to_string(end.exit_code);
}

std::string ShellWords(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    if (IsPlain(word)) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) {
      if (c == '\'')
        line += "'\\''";
      else
        line += c;
    }
    line += '\'';
  }
  return line;
}

}  // namespace plumbline
