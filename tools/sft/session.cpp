#include "tools/sft/session.h"

#include <unistd.h>

#include <algorithm>
#include <set>

#include "tools/sft/definitions.h"
#include "tools/sft/msg_text.h"
#include "tools/terminal/units.h"

namespace sft::tool {

using namespace std::chrono_literals;

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds look_pause{20};
constexpr std::chrono::milliseconds dds_readers_settle{250};
constexpr std::chrono::milliseconds settle_time{100};  // the time to discover the other publishers of a topic

/// Returns the QoS to request. If every publisher of the topic is durable, durability is requested, so that
/// retained samples are received, too. Reliability is not requested, because a publisher may wait for
/// reliable readers, and a tool must not slow it down.
Qos common_offer(const std::string& topic, const DomainSnapshot& domain) {
  Qos qos{.durability = Durability::transient_local};
  bool published = false;
  for (const DomainSnapshot::Endpoint& publisher : domain.publishers) {
    if (publisher.topic != topic) continue;
    published = true;
    qos.durability = std::min(qos.durability, requestable_durability(publisher));
  }
  return published ? qos : Qos{};
}

/// Returns a publisher of the topic if all its publishers are announced without the fields of their type.
/// If the topic has no publishers, does the same with its subscribers. Otherwise returns null.
const DomainSnapshot::Endpoint* undescribed_one(const std::string& topic, const DomainSnapshot& domain) {
  const DomainSnapshot::Endpoint* first = nullptr;
  for (const auto* endpoints : {&domain.publishers, &domain.subscribers}) {
    for (const DomainSnapshot::Endpoint& e : *endpoints) {
      if (e.topic != topic) continue;
      if (e.type) return nullptr;
      if (first == nullptr) first = &e;
    }
    if (first != nullptr) return first;
  }
  return nullptr;
}

std::string undescribed_by_dds(const DomainSnapshot::Endpoint& endpoint) {
  return "only nodes of DDS have the topic '" + printable(endpoint.topic) +
         "', which announce no fields of '" + printable(ros_name(endpoint.type_name)) +
         "': name a directory with its .msg files by --include";
}

}  // namespace

Result<Session> Session::open(const CommonOptions& options, std::string_view command, Stop& stop,
                              Output& output) {
  NodeOptions node{.name = "sft_" + std::string(command) + "_" + std::to_string(getpid())};
  node.domain = options.domain;
  node.use_sim_time = options.sim_time;
  node.discovery.interfaces = options.interfaces;
  node.discovery.peers = options.peers;
  node.shm.start_daemon = command == "perf";
  using enum NodeOptions::VanillaDds;
  node.vanilla_dds = options.dds.value_or(command == "perf" ? automatic : always);
  return Node::open(node).map([&](Node&& opened) {
    (void)opened.domain();  // from now on, the node discovers all other nodes
    return Session(std::move(opened), options, stop, output);
  });
}

DomainSnapshot Session::domain() const {
  DomainSnapshot domain = node_.domain();
  std::erase_if(domain.pairs, [&](const DomainSnapshot::Pair& pair) {
    return std::ranges::any_of(domain.subscribers, [&](const DomainSnapshot::Endpoint& s) {
      return s.is_own && s.id == pair.subscriber;
    });
  });
  for (auto* endpoints : {&domain.publishers, &domain.subscribers}) {
    std::erase_if(*endpoints, [](const DomainSnapshot::Endpoint& e) { return e.is_own; });
  }
  return domain;
}

DomainSnapshot Session::look_around() {
  stop_->wait_for(seconds(options_.wait_s));
  return domain();
}

bool Session::wait_until(const std::function<bool(const DomainSnapshot&)>& enough, double for_s) {
  const auto end = Clock::now() + seconds(for_s);
  for (;;) {
    if (enough(domain())) return true;
    if (Clock::now() >= end || stop_->wait_for(look_pause)) return false;
  }
}

std::optional<std::string> Session::known_name(std::string_view topic, const DomainSnapshot& domain) {
  const std::string plain = plain_name(topic);
  const std::string given(topic);
  for (const std::string& name : {given, plain, "/" + plain}) {
    const auto has = [&](const DomainSnapshot::Endpoint& e) { return e.topic == name; };
    if (std::ranges::any_of(domain.publishers, has) || std::ranges::any_of(domain.subscribers, has))
      return name;
  }
  return std::nullopt;
}

Result<void> Session::check_name(std::string_view topic) {
  if (!topic.starts_with('~')) return {};
  (void)look_around();
  const Error error{Errc::invalid_argument, "the topic '" + printable(topic) +
                                                "' is private to a node: name it in full, as 'sft ls' does"};
  return tl::unexpected(explained(error, topic));
}

Error Session::explained(Error error, std::string_view topic) const {
  const DomainSnapshot domain = this->domain();
  std::set<std::string> sentences;
  for (const auto* endpoints : {&domain.publishers, &domain.subscribers}) {
    for (const DomainSnapshot::Endpoint& e : *endpoints) {
      if (e.given_topic == topic)
        sentences.insert("; node '" + printable(e.node) + "' calls the topic '" + printable(e.topic) +
                         "' so");
    }
  }
  for (const std::string& sentence : sentences) error.message += sentence;
  if (!options_.peers.empty()) error.message += std::string("; ") + peers_name_each_other;
  return error;
}

Result<FoundTopic> Session::find(std::string_view topic) {
  if (const Result<void> sound = check_name(topic); !sound) return tl::unexpected(sound.error());
  std::optional<FoundTopic> found;
  Error error{Errc::unavailable, "stopped before the topic was found"};
  const auto look = [&](const DomainSnapshot& domain) {
    const std::string name = known_name(topic, domain).value_or(plain_name(topic));
    Result<DynamicType> type = node_.find_type(name, 0s);
    const auto* const undescribed = type ? nullptr : undescribed_one(name, domain);
    if (undescribed != nullptr) {
      const std::string why = undescribed->dds ? undescribed_by_dds(*undescribed) : type.error().message;
      type = definition_of(*undescribed, options_).map_error([&](const Error& of_files) {
        const bool has_none = of_files.code == Errc::invalid_argument;  // a name in this form cannot belong
                                                                        // to a .msg file
        return Error{has_none ? Errc::unavailable : of_files.code, why + "; " + of_files.message};
      });
    }
    if (type) {
      found = FoundTopic{name, *type, Qos{}};
    } else {
      error = type.error();
    }
    return found.has_value() || undescribed != nullptr || error.code == Errc::type_mismatch ||
           error.code == Errc::invalid_argument;
  };
  wait_until(look);
  if (!found) return tl::unexpected(explained(error, topic));
  stop_->wait_for(settle_time);
  found->requested = common_offer(found->name, domain());
  return *std::move(found);
}

Durability requestable_durability(const DomainSnapshot::Endpoint& publisher) {
  return publisher.dds && publisher.qos.reliability == best_effort ? volatile_ : publisher.qos.durability;
}

void await_dds_readers(const DynamicPublisher& publisher, Stop& stop) {
  if (publisher.status().vanilla_readers > 0) stop.wait_for(dds_readers_settle);
}

std::optional<std::string> Session::undescribed(std::string_view topic) const {
  const DomainSnapshot domain = this->domain();
  std::optional<std::string> name = known_name(topic, domain);
  const DomainSnapshot::Endpoint* const one = name ? undescribed_one(*name, domain) : nullptr;
  if (one == nullptr || one->dds) name.reset();
  return name;
}

ExitCode give_up(const Error& error) {
  complain(error.message);
  return error.code == Errc::unavailable ? ExitCode::nothing : ExitCode::failed;
}

}  // namespace sft::tool
