// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

namespace plumbline {

/// Longer without input is a pause: nobody worked.
inline constexpr double kLongestPause_s = 60;

/// The time that somebody spent on each object, until it is written with an edit. All times in
/// seconds, of one clock.
class WorkTime {
 public:
  /// An object that is about to be placed.
  static constexpr const char* kNext = "";

  explicit WorkTime(double now_s) : last_input_s_(now_s) {}

  /// There was input now: the time since the last input counts for an object, or `kNext`, or for
  /// nothing.
  void NoteInput(double now_s, const std::optional<std::string>& object);
  /// Not yet written, 0 or more.
  double Of(const std::string& object) const;
  /// The same in whole tenths, as it is written.
  double ToWrite(const std::string& object) const;
  /// It was written (`seconds` > 0), or taken back by an undo (< 0).
  void Written(const std::string& object, double seconds);
  void Forget(const std::string& object) { seconds_.erase(object); }
  /// What was meant for the next object was spent on this one.
  void GiveNextTo(const std::string& object);

 private:
  double last_input_s_;
  std::map<std::string, double> seconds_;
};

}  // namespace plumbline
