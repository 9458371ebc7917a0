// SPDX-License-Identifier: Apache-2.0
#pragma once

// What panels ask for. Small values; nothing here points at the window or the engine.

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "engine/base/ids.h"
#include "engine/mapping/mapper_options.h"
#include "engine/snapshot/annotation_commands.h"

namespace plumbline {

/// Plays from the frame that is shown; past the newest mapped frame the mapper goes on.
struct PlayCommand {};
struct PauseCommand {};
struct TogglePlayCommand {};
/// Moves by frames, negative: back.
struct StepCommand {
  int frames = 1;
};
/// Shows a frame; one that is not yet mapped is mapped towards, as fast as it goes.
struct SeekCommand {
  int frame = 0;
};
/// Factor on the rate of the sequence; 0: as fast as it goes.
struct SetSpeedCommand {
  double speed = 1;
};

/// Frames that playing keeps to, both included; nothing: up to the first or last.
struct SetRangeCommand {
  std::optional<int> begin, end;
};
/// Playing starts again at the end.
struct SetLoopCommand {
  bool loop = false;
};

/// Maps on as fast as it goes and shows the newest frame; a seek or step into the past leaves the
/// mapper at work. Off: stops both. Nothing in a recorded run.
struct FollowNewestCommand {
  bool on = true;
};

/// The options of the frames that are mapped from now on. Nothing in a recorded run.
struct SetOptionsCommand {
  MapperOptions options;
};

/// Scores an object of the frame that is shown again, with what was not tried: the truth, places
/// around the mean. The answer is a ProbeView.
struct ProbeCommand {
  ObjectId object;
  int particle = -1;       ///< Also this one; -1: none.
  bool reference = false;  ///< Also by the reference scorer, which takes longer.
  bool maps = false;       ///< Also the score over two parameters at once.
  int hovered = -1;        ///< Also the outline of this particle.
  std::string truth = {};  ///< This true instance instead of an object, by its id; "": `object`.
};

/// What is shown besides the frames, and takes time to work out: it is kept up to date for as long
/// as it is asked for.
struct WatchCommand {
  ObjectId object;         ///< Ranks of its particles; not valid: of none.
  bool history = false;    ///< Also what the history says of it: an ObjectHistory.
  bool relations = false;  ///< Of the objects of the frame.
  std::string edges;       ///< Edges to compare the run's with, as --edges names them; empty: none.
  bool score_map = false;  ///< What the detector makes of a box like that of `object` elsewhere.
  bool timings = false;    ///< Statistics of the stages over all frames: a TimingStatistics.
  bool operator==(const WatchCommand&) const = default;
};

/// For the process that plays and maps.
using PlaybackCommand =
    std::variant<PlayCommand, PauseCommand, TogglePlayCommand, StepCommand, SeekCommand,
                 SetSpeedCommand, SetRangeCommand, SetLoopCommand, FollowNewestCommand,
                 SetOptionsCommand, ProbeCommand, WatchCommand>;

/// An id that is not valid clears the selection.
struct SelectObjectCommand {
  ObjectId object;
};
/// Selects a true instance instead of an object, by its id; "" clears the selection.
struct SelectTruthCommand {
  std::string truth;
};
/// Index into the particles of the selected object; -1 clears.
struct SelectParticleCommand {
  int particle = -1;
};
/// Marks the hypothesis that lies nearest to one of the modes of the selected object, and turns the
/// map to it.
struct FocusModeCommand {
  int mode = 0;
};
/// All views leave out what is not confirmed, but for the selected object.
struct ConfirmedOnlyCommand {
  bool on = true;
};
/// A panel fills the workspace; "": all come back.
struct MaximizePanelCommand {
  std::string panel;
};
/// A panel goes from the workspace, or comes back.
struct HidePanelCommand {
  std::string panel;
  bool hide = true;
};
/// One of the built-in arrangements of the panels or of the user's own.
struct ChooseLayoutCommand {
  std::string name;
};
/// Keeps the arrangement as it is now, under a name of the user's.
struct KeepLayoutCommand {
  std::string name;
};
struct ForgetLayoutCommand {
  std::string name;
};
/// The particle of the selected object under the mouse, while it is; its outline is drawn.
struct HoverParticleCommand {
  int particle = -1;
};
/// The 3-D view moves with the camera of the sequence.
struct FollowCommand {
  bool follow = false;
};
/// The 3-D view is that of the sequence's camera, with its image behind.
struct LookThroughCommand {
  bool on = true;
};
/// Remembers a frame with a note; replaces the bookmark that the frame has.
struct BookmarkCommand {
  int frame = 0;
  std::string note;
};
struct RemoveBookmarkCommand {
  int frame = 0;
};
/// How many image views there are, 1 to 5.
struct ImageViewsCommand {
  int count = 5;
};
/// Shows a panel in an image view; what was there goes where it was.
struct PlaceViewCommand {
  int view = 0;
  std::string panel;
};
/// Brings a panel to the front, by its id, where several share a place.
struct ShowPanelCommand {
  std::string panel;
};
/// Of a panel that is drawn in this frame of the window: it shows what has to be worked out.
struct NeedCommand {
  enum class What { kObjectHistory, kRelations, kOtherEdges, kScoreMap, kTimings };
  What what = What::kRelations;
  std::string edges;  ///< Of kOtherEdges.
};
/// Full screen with a guided camera and captions, until any key.
struct PresentCommand {
  bool on = true;
};
/// The next key strokes name the frame to go to.
struct AskFrameCommand {};
/// Index into the hypotheses of the ProbeView: this one's contour is drawn.
struct SelectHypothesisCommand {
  int hypothesis = 0;
};
/// Opens the dialog that forks the run at the frame that is shown, or closes it.
struct AskForkCommand {
  bool show = true;
};
/// Opens the dialog that changes the options of the run that is being mapped, or closes it.
struct AskOptionsCommand {
  bool show = true;
};
/// Opens the sheet that shows the networks of the run and offers others, or closes it.
struct AskNetworksCommand {
  bool show = true;
};
/// Downloads one of the listed detectors.
struct FetchNetworkCommand {
  std::string name;
};
struct StopFetchingCommand {};
/// Opens the same sheet and says there what a network file is.
struct LookAtNetworkCommand {
  std::string file;
};
/// Maps the open sequence again from its first frame, with these edges and this detector as --edges
/// and --detector name them; "": as before. Nothing in a recorded run.
struct UseNetworksCommand {
  std::string edges, detector;
};
/// Opens the sequence that could not be opened once more, with poses from its images and its IMU
/// (--poses vio).
struct FindPosesCommand {};
/// Maps the open run again from the frame after `frame` on, into a file of its own, which is then
/// opened beside it.
struct ForkCommand {
  int frame = 0;
  MapperOptions options;
  std::uint64_t seed = 0;
  std::string out;
  std::string plant = {};  ///< A true instance that the mapper is given as a candidate; "": none.
};
struct CancelForkCommand {};
/// Opens another run of the same sequence beside what is open; "": closes it.
struct CompareRunCommand {
  std::string run;
};
enum class RunShown { kFirst, kOther, kBlink, kBeside };
/// Which of two runs the window shows.
struct ShowRunCommand {
  RunShown shown = RunShown::kFirst;
};

/// For the workspace that shows runs.
using InspectCommand =
    std::variant<SelectObjectCommand, SelectTruthCommand, SelectParticleCommand,
                 HoverParticleCommand, SelectHypothesisCommand, FollowCommand, LookThroughCommand,
                 BookmarkCommand, RemoveBookmarkCommand, AskFrameCommand, ImageViewsCommand,
                 PlaceViewCommand, ShowPanelCommand, NeedCommand, PresentCommand, AskForkCommand,
                 AskOptionsCommand, AskNetworksCommand, FetchNetworkCommand, StopFetchingCommand,
                 LookAtNetworkCommand, UseNetworksCommand, ForkCommand, CancelForkCommand,
                 CompareRunCommand, ShowRunCommand, FocusModeCommand, ConfirmedOnlyCommand,
                 MaximizePanelCommand, HidePanelCommand, ChooseLayoutCommand, KeepLayoutCommand,
                 ForgetLayoutCommand, FindPosesCommand>;

/// Turns the 3-D view to the selection.
struct FocusSelectionCommand {};
struct ResetViewCommand {};
/// Azimuth and elevation of the eye about the focus of the 3-D view [rad].
struct ViewDirectionCommand {
  double azimuth_rad = 0, elevation_rad = 0;
};

/// For the 3-D view of the workspace that shows.
using ViewCommand = std::variant<FocusSelectionCommand, ResetViewCommand, ViewDirectionCommand>;

enum class WorkspaceId { kInspect, kAnnotate };
struct SetThemeCommand {
  bool light = false;
};
struct ShowPaletteCommand {
  bool show = true;
  std::string within;  ///< Only what has these words is offered.
};
/// Writes the window as PNG; "" chooses a name in the working folder.
struct ScreenshotCommand {
  std::string file;
  std::string of;  ///< The part that this widget fills ("panel.image"); "": all.
};
/// Says something in the status bar for a while.
struct NoteCommand {
  std::string text;
};
struct FullScreenCommand {
  bool on = true;
};
struct ShowHelpCommand {
  bool show = true;
};
/// Size of text and controls, 1 = normal.
struct SetUiScaleCommand {
  double scale = 1;
};
/// Opens a sequence, a run file, or (kDemoPath) the built-in sequence instead of what is open.
struct OpenCommand {
  std::string path;
};
inline constexpr const char* kDemoPath = "demo:";
/// Shows the other workspace; what is open in either stays open.
struct SwitchWorkspaceCommand {
  WorkspaceId workspace = WorkspaceId::kInspect;
};
struct QuitCommand {};

/// For the window itself.
using WindowCommand =
    std::variant<SetThemeCommand, ShowPaletteCommand, ScreenshotCommand, NoteCommand,
                 FullScreenCommand, ShowHelpCommand, SetUiScaleCommand, OpenCommand,
                 SwitchWorkspaceCommand, QuitCommand>;

using Command =
    std::variant<PlaybackCommand, InspectCommand, ViewCommand, WindowCommand, AnnotationCommand>;

/// Whether `Variant` is one of several types that C is among.
template <typename C, typename Variant>
inline constexpr bool kIsAmong = false;
template <typename C, typename... Types>
inline constexpr bool kIsAmong<C, std::variant<Types...>> = (std::is_same_v<C, Types> || ...);

/// The group that a command belongs to; a command that is in none does not compile.
template <typename C>
struct GroupOf {
  using type = std::conditional_t<
      kIsAmong<C, PlaybackCommand>, PlaybackCommand,
      std::conditional_t<kIsAmong<C, InspectCommand>, InspectCommand,
                         std::conditional_t<kIsAmong<C, ViewCommand>, ViewCommand,
                                            std::conditional_t<kIsAmong<C, AnnotationCommand>,
                                                               AnnotationCommand, WindowCommand>>>>;
  static_assert(kIsAmong<C, type>, "this command is in none of the groups");
};

/// Where panels put what they ask for.
class CommandSink {
 public:
  virtual ~CommandSink() = default;
  template <typename C>
  void Post(C command) {
    Send(typename GroupOf<C>::type(std::move(command)));
  }

 protected:
  virtual void Send(Command command) = 0;
};

}  // namespace plumbline
