// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/graph_plan.h"

#include <algorithm>
#include <iterator>
#include <set>

#include <nlohmann/json.hpp>

#include "engine/base/data_paths.h"
#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/transport/endpoint.h"

namespace plumbline {
namespace {

constexpr int kGraphVersion = 1;
constexpr std::size_t kMostNodes = 64;

/// Throws std::runtime_error on a key that is not among the known ones.
void CheckKeys(const nlohmann::json& object, const std::vector<std::string>& known) {
  if (!object.is_object()) throw std::runtime_error("an object was expected");
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    throw std::runtime_error("'" + key + "' is not known; did you mean '" +
                             NearestName(key, known) + "'?");
  }
}

NodeKind KindFromName(const std::string& name) {
  const auto& names = EnumNames<NodeKind>::names;
  const auto found = std::find(std::begin(names), std::end(names), name);
  if (found == std::end(names))
    throw std::runtime_error("'" + name +
                             "' is no kind of node; it is player, edges, detector, vio, "
                             "mapper, recorder, camera, imu or other");
  return static_cast<NodeKind>(found - std::begin(names));
}

/// The names of others that a node has, and where they stand.
struct NamedInput {
  const char* key;
  std::string GraphNode::*field;
  /// Which kinds answer it.
  std::vector<NodeKind> kinds;
};

const std::vector<NamedInput>& NamedInputs() {
  static const std::vector<NamedInput> kInputs = {
      {"images", &GraphNode::images, {NodeKind::kPlayer}},
      {"edges", &GraphNode::edges, {NodeKind::kEdges, NodeKind::kPlayer}},
      {"proposals", &GraphNode::proposals, {NodeKind::kDetector, NodeKind::kPlayer}},
      {"reports", &GraphNode::reports, {NodeKind::kMapper}},
      {"recorder", &GraphNode::recorder, {NodeKind::kRecorder}},
      {"poses", &GraphNode::poses, {NodeKind::kVio}}};
  return kInputs;
}

GraphNode NodeFromJson(const nlohmann::json& json) {
  CheckKeys(json, {"name", "kind", "endpoint", "images", "edges", "proposals", "reports",
                   "recorder", "poses", "source", "command", "start"});
  GraphNode node;
  node.name = json.at("name").get<std::string>();
  if (!IsFileName(node.name)) throw std::runtime_error("'" + node.name + "' is no name of a node");
  node.kind = KindFromName(json.at("kind").get<std::string>());
  node.endpoint = json.value("endpoint", "");
  for (const NamedInput& input : NamedInputs()) node.*input.field = json.value(input.key, "");
  node.source = json.value("source", "");
  node.command = json.value("command", std::vector<std::string>());
  node.start = json.value("start", true);
  if (!node.endpoint.empty()) {
    const Result<Endpoint> endpoint = Endpoint::Parse(node.endpoint);
    if (!endpoint.ok()) throw std::runtime_error(endpoint.error().message);
  }
  if (node.kind == NodeKind::kOther && node.start && node.command.empty())
    throw std::runtime_error("the node '" + node.name +
                             "' of kind other has no \"command\" to start it with");
  return node;
}

std::ptrdiff_t CountOf(const GraphPlan& plan, NodeKind kind) {
  return std::count_if(plan.nodes.begin(), plan.nodes.end(),
                       [kind](const GraphNode& node) { return node.kind == kind; });
}

/// What is missing or names something else. Throws std::runtime_error.
void CheckWiring(const GraphPlan& plan) {
  std::set<std::string> names;
  for (const GraphNode& node : plan.nodes) {
    if (!names.insert(node.name).second)
      throw std::runtime_error("two nodes are named '" + node.name + "'");
  }
  for (const GraphNode& node : plan.nodes) {
    for (const NamedInput& input : NamedInputs()) {
      const std::string& name = node.*input.field;
      if (name.empty()) continue;
      const GraphNode* found = plan.Find(name);
      if (found == nullptr)
        throw std::runtime_error("\"" + std::string(input.key) + "\" of '" + node.name +
                                 "' names the node '" + name + "', which is not there");
      const bool fits =
          found->kind == NodeKind::kOther ||
          std::find(input.kinds.begin(), input.kinds.end(), found->kind) != input.kinds.end();
      if (!fits)
        throw std::runtime_error("\"" + std::string(input.key) + "\" of '" + node.name +
                                 "' names '" + name + "', a " + std::string(NameOf(found->kind)) +
                                 ", which has none");
    }
    const auto needs = [&](const std::string& what, const char* key) {
      if (what.empty())
        throw std::runtime_error("the " + std::string(NameOf(node.kind)) + " '" + node.name +
                                 "' needs \"" + key + "\"");
    };
    switch (node.kind) {
      case NodeKind::kEdges:
      case NodeKind::kDetector:
      case NodeKind::kVio:
        needs(node.images, "images");
        break;
      case NodeKind::kMapper:
        needs(node.images, "images");
        needs(node.recorder, "recorder");
        break;
      case NodeKind::kRecorder:
        needs(node.images, "images");
        needs(node.reports, "reports");
        break;
      default:
        break;
    }
  }
  for (const NodeKind kind : {NodeKind::kCamera, NodeKind::kImu}) {
    if (CountOf(plan, kind) > 1)
      throw std::runtime_error("it has two nodes of kind " + std::string(NameOf(kind)) +
                               "; one recording has one");
  }
  if (plan.FirstOf(NodeKind::kImu) != nullptr && plan.FirstOf(NodeKind::kCamera) == nullptr)
    throw std::runtime_error("it has a node of kind imu, and none of kind camera");
  const GraphNode* mapper = plan.FirstOf(NodeKind::kMapper);
  const GraphNode* recorder = plan.FirstOf(NodeKind::kRecorder);
  if (mapper != nullptr && recorder != nullptr && mapper->poses != recorder->poses)
    throw std::runtime_error("the mapper and the recorder need the same \"poses\"");
  for (const NodeKind kind : {NodeKind::kPlayer, NodeKind::kMapper, NodeKind::kRecorder}) {
    const auto count = CountOf(plan, kind);
    if (count != 1)
      throw std::runtime_error("it has " + std::to_string(count) + " nodes of kind " +
                               std::string(NameOf(kind)) + "; one is needed");
  }
}

GraphRecording RecordingFromJson(const nlohmann::json& json) {
  CheckKeys(json, {"began_ns", "seconds", "lossless", "exposure_ms"});
  GraphRecording recording;
  recording.began_ns = json.value("began_ns", std::int64_t{0});
  recording.seconds = json.value("seconds", 0.0);
  recording.lossless = json.value("lossless", false);
  if (json.contains("exposure_ms")) recording.exposure_ms = json.at("exposure_ms").get<double>();
  return recording;
}

nlohmann::json RecordingToJson(const GraphRecording& recording) {
  nlohmann::json json = {{"began_ns", recording.began_ns},
                         {"seconds", recording.seconds},
                         {"lossless", recording.lossless}};
  if (recording.exposure_ms) json["exposure_ms"] = *recording.exposure_ms;
  return json;
}

}  // namespace

std::string_view NameOf(NodeKind kind) {
  return EnumNames<NodeKind>::names[static_cast<std::size_t>(kind)];
}

const GraphNode* GraphPlan::Find(const std::string& name) const {
  for (const GraphNode& node : nodes)
    if (node.name == name) return &node;
  return nullptr;
}

const GraphNode* GraphPlan::FirstOf(NodeKind kind) const {
  for (const GraphNode& node : nodes)
    if (node.kind == kind) return &node;
  return nullptr;
}

Result<GraphPlan> GraphFromJson(const nlohmann::json& json) {
  GraphPlan plan;
  try {
    CheckKeys(json, {"version", "note", "nodes", "keys", "recipe", "out", "resume", "folder",
                     "recording"});
    const int version = IntFromJson(json.at("version"));
    if (version != kGraphVersion) {
      return Error{ErrorCode::kUnsupported, "it is a graph of version " + std::to_string(version) +
                                                ", and this program reads version " +
                                                std::to_string(kGraphVersion)};
    }
    for (const nlohmann::json& node : json.at("nodes")) {
      if (plan.nodes.size() >= kMostNodes) throw std::runtime_error("it has too many nodes");
      plan.nodes.push_back(NodeFromJson(node));
    }
    plan.keys = json.value("keys", "");
    plan.out = json.value("out", "");
    plan.resume = json.value("resume", false);
    plan.folder = json.value("folder", "");
    if (json.contains("recording")) plan.recording = RecordingFromJson(json.at("recording"));
    if (json.contains("recipe")) {
      Result<RunRecipe> recipe = RecipeFromJson(json.at("recipe"));
      if (!recipe.ok()) return recipe.error();
      plan.recipe = std::move(recipe).value();
    }
    CheckWiring(plan);
  } catch (const std::exception& error) {
    return Error{ErrorCode::kInvalidInput, std::string("it is no graph: ") + error.what()};
  }
  return plan;
}

nlohmann::json GraphToJson(const GraphPlan& plan) {
  nlohmann::json nodes = nlohmann::json::array();
  for (const GraphNode& node : plan.nodes) {
    nlohmann::json row = {{"name", node.name}, {"kind", NameOf(node.kind)}};
    if (!node.endpoint.empty()) row["endpoint"] = node.endpoint;
    for (const NamedInput& input : NamedInputs())
      if (!(node.*input.field).empty()) row[input.key] = node.*input.field;
    if (!node.source.empty()) row["source"] = node.source;
    if (!node.command.empty()) row["command"] = node.command;
    if (!node.start) row["start"] = false;
    nodes.push_back(std::move(row));
  }
  nlohmann::json json = {{"version", kGraphVersion}, {"nodes", std::move(nodes)}};
  if (!plan.keys.empty()) json["keys"] = std::filesystem::absolute(plan.keys).string();
  if (!plan.out.empty()) json["out"] = std::filesystem::absolute(plan.out).string();
  if (!plan.folder.empty()) json["folder"] = std::filesystem::absolute(plan.folder).string();
  if (plan.resume) json["resume"] = true;
  if (plan.FirstOf(NodeKind::kCamera) != nullptr)
    json["recording"] = RecordingToJson(plan.recording);
  if (plan.recipe) json["recipe"] = RecipeToJson(*plan.recipe);
  return json;
}

Result<GraphPlan> ReadGraph(const std::filesystem::path& file) {
  const Result<nlohmann::json> json = ReadJson(file);
  if (!json.ok()) return json.error();
  Result<GraphPlan> plan = GraphFromJson(*json);
  if (!plan.ok())
    return Error{plan.error().code, "'" + file.string() + "': " + plan.error().message};
  if (!plan->keys.empty() && plan->keys.is_relative())
    plan->keys = std::filesystem::absolute(file).parent_path() / plan->keys;
  return plan;
}

Status ResolveGraph(const std::filesystem::path& folder, GraphPlan& plan) {
  plan.folder = folder;
  for (GraphNode& node : plan.nodes) {
    if (!node.endpoint.empty()) continue;
    node.endpoint = "ipc://" + (folder / node.name).string();
    const Result<Endpoint> endpoint = Endpoint::Parse(node.endpoint);
    if (!endpoint.ok()) return endpoint.error();
  }
  return {};
}

}  // namespace plumbline
