// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace plumbline {

/// Ends the poll of another thread, which waits for sockets and for this. Signals that come before
/// it is taken are one.
class WakeSignal {
 public:
  WakeSignal();
  ~WakeSignal();
  WakeSignal(const WakeSignal&) = delete;
  WakeSignal& operator=(const WakeSignal&) = delete;

  void Send() const;                              ///< From any thread.
  void Take() const;                              ///< After a poll said that it was sent.
  int descriptor() const { return descriptor_; }  ///< To poll for being readable.

 private:
  int descriptor_;
};

}  // namespace plumbline
