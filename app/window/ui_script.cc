// SPDX-License-Identifier: Apache-2.0
#include "app/window/ui_script.h"

#include <algorithm>
#include <iterator>

#include "engine/base/files.h"
#include "ui/files/script_file.h"
#include "ui/framework/actions.h"

namespace plumbline {
namespace {

Error Wrong(const nlohmann::json& step, const std::string& why) {
  return {ErrorCode::kInvalidInput, "script step " + step.dump() + ": " + why};
}

int ButtonOf(const nlohmann::json& step) {
  const std::string name = step.value("button", "left");
  return name == "right"    ? ImGuiMouseButton_Right
         : name == "middle" ? ImGuiMouseButton_Middle
                            : ImGuiMouseButton_Left;
}

/// Whether every key of `wanted` has that value in `state` ({"min": x}: at least x, {"max": x}: at
/// most).
bool Matches(const nlohmann::json& wanted, const nlohmann::json& state) {
  return std::all_of(wanted.items().begin(), wanted.items().end(), [&](const auto& item) {
    const auto found = state.find(item.key());
    if (found == state.end()) return false;
    const nlohmann::json& value = item.value();
    if (value.is_object() && value.contains("min"))
      return found->is_number() && *found >= value["min"];
    if (value.is_object() && value.contains("max"))
      return found->is_number() && *found <= value["max"];
    return *found == value;
  });
}

}  // namespace

Result<UiScript> UiScript::Load(const std::filesystem::path& file) {
  const auto steps = ReadScript(file);
  if (!steps.ok()) return steps.error();
  UiScript script;
  script.steps_.assign(steps->begin(), steps->end());
  return script;
}

Result<ImVec2> UiScript::At(const std::string& name, double share_x, double share_y,
                            const WidgetLog& widgets) const {
  const WidgetLog::Rect* rect = widgets.Find(name);
  if (rect == nullptr) {
    std::string known;
    for (const auto& [other, ignored] : widgets.rects()) known += " " + other;
    return Error{ErrorCode::kNotFound, "the window shows no '" + name + "'; it shows:" + known};
  }
  return ImVec2(rect->low.x + static_cast<float>(share_x) * (rect->high.x - rect->low.x),
                rect->low.y + static_cast<float>(share_y) * (rect->high.y - rect->low.y));
}

Status UiScript::ExpandMouse(const nlohmann::json& step, const WidgetLog& widgets) {
  for (const char* kind : {"click", "double_click", "drag", "wheel", "hover"}) {
    if (!step.contains(kind)) continue;
    const std::string name = step[kind];
    const std::string what = kind;
    const nlohmann::json from =
        step.value("from", step.value("at", nlohmann::json::array({0.5, 0.5})));
    const auto start = At(name, from[0], from[1], widgets);
    if (!start.ok()) return start.error();
    const int button = ButtonOf(step);
    const bool shift = step.value("shift", false), control = step.value("control", false),
               alt = step.value("alt", false);
    const auto add = [&](Action action) {
      action.shift = shift;
      action.control = control;
      action.alt = alt;
      actions_.push_back(std::move(action));
    };
    add({.mouse = *start});
    if (what == "hover") {
      for (int i = 0; i < 4; ++i) add({});
    } else if (what == "wheel") {
      const int amount = step.value("amount", 1);
      for (int i = 0; i < std::abs(amount); ++i) add({.wheel = amount > 0 ? 1.0f : -1.0f});
    } else {
      add({.button_down = button});
      if (what == "drag") {
        const auto end = At(name, step.at("to")[0], step.at("to")[1], widgets);
        if (!end.ok()) return end.error();
        constexpr int kMoves = 8;
        for (int i = 1; i <= kMoves; ++i) {
          const float t = static_cast<float>(i) / kMoves;
          add({.mouse =
                   ImVec2(start->x + t * (end->x - start->x), start->y + t * (end->y - start->y))});
        }
      }
      add({.button_up = button});
      if (what == "double_click") {
        add({.button_down = button});
        add({.button_up = button});
      }
    }
    actions_.push_back({});
    return {};
  }
  return Wrong(step, "is not known; see docs/panels.md");
}

Status UiScript::Expand(const nlohmann::json& step, const WidgetLog& widgets, const Host& host) {
  if (step.contains("key")) {
    const int key = KeyByName(step["key"].get<std::string>());
    if (key < 0) return Wrong(step, "there is no such key");
    const bool shift = step.value("shift", false), control = step.value("control", false),
               alt = step.value("alt", false);
    for (int i = 0; i < step.value("times", 1); ++i) {
      actions_.push_back({.key_down = key, .shift = shift, .control = control, .alt = alt});
      actions_.push_back({.key_up = key});
    }
  } else if (step.contains("text")) {
    actions_.push_back({.text = step["text"].get<std::string>()});
    actions_.push_back({});
  } else if (step.contains("wait_frames")) {
    for (int i = 0; i < step["wait_frames"].get<int>(); ++i) actions_.push_back({});
  } else if (step.contains("screenshot") || step.contains("dump_state")) {
    actions_.push_back({.after = step});
  } else if (step.contains("resize")) {
    host.resize(step["resize"][0], step["resize"][1]);
    for (int i = 0; i < 6; ++i) actions_.push_back({});
  } else if (step.contains("drop")) {
    host.drop(step["drop"].get<std::vector<std::string>>());
    actions_.push_back({});
  } else if (step.contains("open")) {
    host.open(step["open"]);
    actions_.push_back({});
  } else {
    return ExpandMouse(step, widgets);
  }
  return {};
}

bool UiScript::Waits(const nlohmann::json& step, const Host& host, Status& status) {
  if (!step.contains("wait_for")) return false;
  const auto now = std::chrono::steady_clock::now();
  if (!waiting_since_) waiting_since_ = now;
  nlohmann::json state = host.state();
  if (Matches(step["wait_for"], state)) {
    waiting_since_.reset();
    steps_.pop_front();
    actions_.push_back({});  // one frame that draws what was waited for
    return false;
  }
  const bool hopeless = state.value("state", "") == "failed" && !step["wait_for"].contains("state");
  const double waited_s = std::chrono::duration<double>(now - *waiting_since_).count();
  if (hopeless || waited_s > step.value("timeout_s", 60.0)) {
    state.erase("widgets");
    state.erase("panels");
    status = Wrong(step, "did not come true; the state is " + state.dump());
  }
  return true;
}

Status UiScript::SetInput(const WidgetLog& widgets, ImGuiIO& io, const Host& host) {
  current_ = {};
  Status status;
  while (actions_.empty() && !steps_.empty()) {
    if (Waits(steps_.front(), host, status)) break;
    if (!actions_.empty()) break;
    status = Expand(steps_.front(), widgets, host);
    if (!status.ok()) return status;
    steps_.pop_front();
  }
  if (!actions_.empty()) {
    current_ = actions_.front();
    actions_.pop_front();
  }
  if (current_.mouse) mouse_ = *current_.mouse;
  if (current_.button_down) buttons_[*current_.button_down] = true;
  if (current_.button_up) buttons_[*current_.button_up] = false;
  if (current_.key_down) held_key_ = current_.key_down;
  if (current_.key_up) held_key_.reset();
  io.MousePos = mouse_;
  std::copy(std::begin(buttons_), std::end(buttons_), io.MouseDown);
  io.MouseWheel = current_.wheel;
  if (!current_.text.empty()) io.AddInputCharactersUTF8(current_.text.c_str());
  std::fill(std::begin(io.KeysDown), std::end(io.KeysDown), false);
  if (held_key_) io.KeysDown[*held_key_] = true;
  io.KeyShift = current_.shift;
  io.KeyCtrl = current_.control;
  io.KeyAlt = current_.alt;
  io.KeySuper = false;
  return status;
}

Status UiScript::AfterDraw(const Host& host) {
  const nlohmann::json& step = current_.after;
  if (step.contains("screenshot"))
    return host.screenshot(step["screenshot"], step.value("of", std::string()));
  if (step.contains("dump_state"))
    return WriteJson(step["dump_state"].get<std::string>(), host.state());
  return {};
}

}  // namespace plumbline
