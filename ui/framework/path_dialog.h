// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/snapshot/folder_view.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// A path that is asked for.
struct PathQuestion {
  enum class What { kOpen, kSave, kFolder };
  What what = What::kOpen;
  std::string title;   ///< "Open a run"
  std::string button;  ///< What its answer does: "Open".
  /// What can be chosen and is shown; empty: everything. With kFolder among them any folder can.
  std::vector<PathKind> kinds = {};
  std::string at = {};         ///< A folder to begin in or a path; "": where the last one ended.
  std::string ending = {};     ///< Of a saved file whose name has none: ".json".
  bool may_replace = false;    ///< Whoever gets the answer asks before something is replaced.
  bool offers_recent = false;  ///< What was opened before can be chosen, too.
  /// Gets an absolute path.
  std::function<void(const std::string& path, CommandSink& sink)> answer;
  std::function<void()> gave_up = {};  ///< May be empty.
};

/// Asks for a path by a list of folders and files, over everything else. It reads no folder itself:
/// `wanted` says which one it needs, Take() brings it. Keys of the list: arrows, letters that jump,
/// Enter, Backspace (up), Esc; Tab goes to the path, where it completes.
class PathDialog {
 public:
  /// @param home, working  Folders that are offered; absolute.
  PathDialog(std::string home, std::string working)
      : home_(std::move(home)), working_(std::move(working)) {}

  /// Instead of what is being asked.
  void Ask(PathQuestion question);
  bool is_open() const { return question_.has_value(); }
  /// The folder that is to be read now, once; nothing if none is.
  std::optional<std::string> TakeWanted();
  /// What is in a folder; of another one than is shown it is ignored.
  void Take(std::shared_ptr<const FolderView> view);
  /// Drawn over everything. @return Whether it has the keyboard to itself.
  bool Draw(const FrameContext& context, CommandSink& sink);

  /// Folders in which something was chosen, the last first: kept from one day to the next.
  const std::vector<std::string>& places() const { return places_; }
  void SetPlaces(std::vector<std::string> places) { places_ = std::move(places); }

 private:
  static constexpr std::size_t kLongest = 1024;

  bool Knows() const { return view_ != nullptr && view_->folder == folder_; }
  bool Takes(PathKind kind) const;
  void Show(const std::string& folder, const std::string& name);
  void GoUp();
  void SetField(const std::string& text);
  void FieldChanged();
  void FindVisible();
  void Mark(int row);
  const FolderEntry* Marked() const;
  const FolderEntry* Find(const std::string& name) const;
  std::string PathOf(const std::string& name) const;
  /// The last part of a path; all of "/".
  static std::string NameIn(const std::string& path);
  /// What the marked row or the path stands for: goes into a folder, answers, or says why not.
  void Choose(bool from_list, CommandSink& sink);
  void Decide(CommandSink& sink);
  void Answer(const std::string& path, CommandSink& sink);
  void Close();
  void Complete();
  void TakeKeys(CommandSink& sink);
  void JumpTo(const std::string& letters);

  void DrawTitle(const FrameContext& context) const;
  void DrawPath(const FrameContext& context, CommandSink& sink);
  void DrawPlaces(const FrameContext& context, float width, float height, CommandSink& sink);
  void DrawList(const FrameContext& context, float height, CommandSink& sink);
  void DrawRow(const FrameContext& context, int row, int columns, CommandSink& sink);
  void DrawBelow(const FrameContext& context, CommandSink& sink);
  struct Remark {
    std::string text;
    ImU32 color;
  };
  /// What is shown, why that will not do, or whether to replace what is there.
  Remark RemarkBelow() const;
  std::string NameOfField() const;

  std::string home_, working_;
  std::vector<std::string> places_;
  std::optional<PathQuestion> question_;
  std::string folder_;                 ///< That is shown; absolute, without a slash at its end.
  std::string base_;                   ///< What a path that is typed without a folder begins with.
  std::optional<std::string> wanted_;  ///< To be read.
  std::shared_ptr<const FolderView> view_;
  std::vector<int> visible_;  ///< Indices into its entries.
  int marked_ = -1;           ///< Index into `visible_`.
  char field_[kLongest] = "";
  std::optional<std::string> new_text_;  ///< For the field, which is being edited.
  std::string typed_;                    ///< The name in it, as far as it was typed: a filter.
  std::string wanted_name_;              ///< To be marked once the folder is known.
  std::string letters_;                  ///< That jump in the list.
  double letters_s_ = -10;               ///< When the last of them came.
  std::string problem_;                  ///< Why the path will not do.
  std::string replaces_;                 ///< The path that is asked about; "": none.
  bool all_ = false, hidden_ = false;    ///< Which entries are shown.
  bool fresh_ = false, focus_ = false, typing_ = false, scroll_ = false;
  bool selects_name_ = false, continues_ = false;  ///< As the field is edited next.
  bool decides_ = false;                           ///< As soon as the folder is known.
};

/// Asks, where there is a window to ask in.
void AskPath(const FrameContext& context, PathQuestion question);
/// Whether a path is being asked for: keys are not for what lies below.
bool AsksForPath(const FrameContext& context);
/// A button "..." beside a field for a path; the question is made as it is clicked.
void BrowseButton(const FrameContext& context, const std::string& name,
                  const std::function<PathQuestion()>& question);
/// Width of that button and the gap before it.
float BrowseWidth(const FrameContext& context);

}  // namespace plumbline
