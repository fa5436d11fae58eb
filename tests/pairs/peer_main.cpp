// negotiation_peer OPTIONS: a node with at most one publisher and one subscriber. It executes the commands
// that it reads from the standard input, which is a socket, until the other side closes the socket. Each
// command and each answer is one JSON object.
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/pairs/echo.h"
#include "tests/pairs/forger.h"
#include "tests/pairs/peer_roles.h"
#include "tests/pairs/status_json.h"

namespace sft::test {
namespace {

using nlohmann::json;

bool is_up(const PublisherStatus::Reader& reader) { return reader.served; }
bool is_up(const SubscriberStatus::Writer& writer) { return writer.matched && writer.alive; }

/// Returns an entry of the node with that name, preferably an entry that is up; null if there is none.
template <class Entries>
json entry_of(const Entries& entries, const std::string& node) {
  json found;
  for (const auto& entry : entries) {
    if (entry.node == node && (found.is_null() || is_up(entry))) found = to_json(entry);
  }
  return found;
}

constexpr const char* topic = "points";
constexpr std::size_t message_bytes_max = 256 * 1024;

/// Collects the lines that the node logs at the level warning or above.
class Warnings {
 public:
  NodeOptions::LogSink sink() {
    return [this](LogLevel level, std::string_view text) {
      if (level < LogLevel::warning) return;
      const std::scoped_lock lock(mutex_);
      warnings_.emplace_back(text);
    };
  }
  json to_json() const {
    const std::scoped_lock lock(mutex_);
    return warnings_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> warnings_;
};

Node open_node(const json& options, Warnings& warnings) {
  NodeOptions node;
  node.log = warnings.sink();
  node.name = options.at("name").get<std::string>();
  if (options.contains("cyclonedds")) node.cyclonedds_config = options["cyclonedds"].get<std::string>();
  node.udp.port = options.value<std::uint16_t>("port", 0);
  // Unless an option says so, the test itself starts the daemon.
  node.shm.start_daemon = options.value("start_daemon", false);
  auto opened = Node::open(node);
  if (!opened) throw std::runtime_error(opened.error().message);
  return std::move(*opened);
}

/// A further node in the same process.
class Neighbour {
 public:
  Neighbour(json options, std::size_t number, Warnings& warnings)
      : node_(open_node(named(std::move(options), number), warnings)),
        publisher_(node_.publisher<PointCloud2>(topic_of(number), {.on_event = offered_.callback()}).value()),
        subscriber_(
            node_.subscriber<PointCloud2>(topic_of(number), {.on_event = requested_.callback()}).value()) {}

  json status() const {
    return {{"readers", std::ranges::count_if(publisher_.status().readers, &PublisherStatus::Reader::served)},
            {"links_renewed", node_.status().links_renewed},
            {"offered", offered_.to_json()},
            {"requested", requested_.to_json()}};
  }

 private:
  static std::string topic_of(std::size_t number) { return "neighbours/of_" + std::to_string(number); }
  static json named(json options, std::size_t number) {
    options["name"] = options.at("name").get<std::string>() + "_" + std::to_string(number);
    options.erase("port");
    return options;
  }

  EventList offered_;
  EventList requested_;
  Node node_;
  Publisher<PointCloud2> publisher_;
  Subscriber<PointCloud2> subscriber_;
};

class Peer {
 public:
  explicit Peer(const json& options) : options_(options), node_(open_node(options, warnings_)) {}

  json obey(const json& command) {
    const std::string what = command.at("do");
    if (what == "status") return status();
    if (what == "look") return look_at(command.at("node"));
    static const std::map<std::string, void (Peer::*)(const json&)> verbs{
        {"publisher", &Peer::open_publisher},
        {"subscriber", &Peer::open_subscriber},
        {"publish", &Peer::publish},
        {"start", &Peer::start},
        {"stop", &Peer::stop},
        {"read", &Peer::read},
        {"rate", &Peer::set_rate},
        {"leave", &Peer::leave},
        {"many publishers", &Peer::many_publishers},
        {"neighbours", &Peer::open_neighbours},
        {"hear", &Peer::hear},
        {"look around", &Peer::look_around},
        {"repeat", &Peer::repeat},
        {"forge", &Peer::forge}};
    (this->*verbs.at(what))(command);
    return json::object();
  }

 private:
  static std::chrono::microseconds period(const json& command) {
    return std::chrono::microseconds(command.at("period_us").get<std::int64_t>());
  }

  void open_publisher(const json& command) {
    publishing_ = std::make_unique<Publishing>(node_, topic, command, offered_);
  }
  void open_subscriber(const json& command) {
    subscribing_ = Subscribing::open(node_, topic, command.at("fields"), command, requested_);
  }
  void publish(const json& command) { publishing_->publish(command.at("count"), period(command)); }
  void start(const json& command) { publishing_->start(period(command)); }
  void stop(const json&) { publishing_->stop(); }
  void read(const json& command) { subscribing_->read(command.at("fields")); }
  void set_rate(const json& command) { subscribing_->set_max_rate_hz(command.at("hz")); }
  void leave(const json&) {
    publishing_.reset();
    subscribing_.reset();
  }
  /// Opens publishers of `count` other topics.
  void many_publishers(const json& command) {
    for (std::size_t i = others_.size(); i < command.at("count"); ++i)
      others_.push_back(node_.publisher<PointCloud2>("other/topic_" + std::to_string(i)).value());
  }

  void open_neighbours(const json& command) {
    for (std::size_t i = 0; i < command.at("count"); ++i)
      neighbours_.push_back(std::make_unique<Neighbour>(options_, i, warnings_));
  }

  /// Makes the node learn of all endpoints from now on, including those of other topics.
  void look_around(const json&) { (void)node_.topics(); }
  void hear(const json&) { echo_ = std::make_unique<Echo>(); }
  void repeat(const json&) { echo_->repeat(); }
  void forge(const json& command) {
    const std::string what = command.at("what");
    if (what == "watch") forger_ = std::make_unique<Forger>();
    if (what == "withdraw") forger_->withdraw_all();
    if (what == "mute") forger_->mute_all(command.at("ahead"));
    if (what == "impersonate processes") forger_->impersonate_processes();
    if (what == "heartbeats") forger_->forge_heartbeats();
    if (what == "outdate heartbeats") forger_->outdate_heartbeats();
    if (what == "outdate announcements") forger_->outdate_announcements();
    if (what == "ask for nothing") forger_->ask_for_nothing();
    if (what == "announce version") forger_->announce_version(command.at("ahead"));
  }

  json status() const {
    json all{{"node", to_json(node_.status())},
             {"warnings", warnings_.to_json()},
             {"offered", offered_.to_json()},
             {"requested", requested_.to_json()}};
    for (const auto& neighbour : neighbours_) all["neighbours"].push_back(neighbour->status());
    if (publishing_) all["publisher"] = to_json(publishing_->status());
    if (subscribing_) {
      all["subscriber"] = to_json(subscribing_->status());
      all["taken"] = subscribing_->taken();
    }
    return all;
  }

  /// Returns the status about one node only, so that the answer is short even if there are many endpoints.
  json look_at(const std::string& node) const {
    json seen{{"shm", node_.status().shm}};
    if (publishing_) {
      seen["reader"] = entry_of(publishing_->status().readers, node);
    }
    if (subscribing_) {
      seen["writer"] = entry_of(subscribing_->status().writers, node);
      for (const json& taken : subscribing_->taken()) {
        if (!seen["writer"].is_null() && taken["writer"] == seen["writer"]["id"]) seen["taken"] = taken;
      }
    }
    return seen;
  }

  EventList offered_;
  EventList requested_;
  Warnings warnings_;
  const json options_;
  Node node_;
  std::vector<Publisher<PointCloud2>> others_;
  std::vector<std::unique_ptr<Neighbour>> neighbours_;
  std::unique_ptr<Publishing> publishing_;
  std::unique_ptr<Subscribing> subscribing_;
  std::unique_ptr<Echo> echo_;
  std::unique_ptr<Forger> forger_;
};

void serve(Peer& peer) {
  std::vector<char> text(message_bytes_max);
  for (;;) {
    const ssize_t bytes = recv(STDIN_FILENO, text.data(), text.size(), 0);
    if (bytes <= 0) return;
    const std::string answer = peer.obey(json::parse(text.begin(), text.begin() + bytes)).dump();
    if (send(STDIN_FILENO, answer.data(), answer.size(), MSG_NOSIGNAL) < 0) return;
  }
}

}  // namespace
}  // namespace sft::test

int main(int argc, char** argv) try {
  sft::test::Peer peer(nlohmann::json::parse(argc == 2 ? argv[1] : "{}"));
  sft::test::serve(peer);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "negotiation_peer: %s\n", error.what());
  return 1;
}
