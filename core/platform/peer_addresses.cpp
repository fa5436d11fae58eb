#include "core/platform/peer_addresses.h"

#include <algorithm>
#include <iterator>

#include "core/platform/quotes.h"
#include "core/platform/thread.h"

namespace sft::core {

namespace {

/// The time within which a reachable name server usually answers.
constexpr std::chrono::milliseconds usual_answer{200};
/// The limits of the pauses between two checks for an answer, where the pauses grow with the duration of
/// the lookup.
constexpr std::chrono::milliseconds answer_pause_min{20}, answer_pause_max{1'000};

/// The parts of a peer: "udp/robot.local:7410" has the parts "udp/", "robot.local" and ":7410". A colon
/// within an IPv6 address does not begin a port.
struct Parts {
  std::string transport;
  std::string host;
  std::string port;
};

Parts parts_of(const std::string& peer) {
  const std::size_t slash = peer.find('/');
  const std::size_t begin = slash == std::string::npos ? 0 : slash + 1;
  Parts parts{.transport = peer.substr(0, begin), .host = peer.substr(begin), .port = {}};
  const std::size_t colon = parts.host.rfind(':');
  const std::size_t bracket = parts.host.rfind(']');
  const bool has_brackets = parts.host.starts_with('[') && bracket != std::string::npos;
  const bool has_port =
      colon != std::string::npos && (has_brackets ? colon > bracket : colon == parts.host.find(':'));
  if (has_port) parts.port = parts.host.substr(colon);
  if (has_port) parts.host.erase(colon);
  if (has_brackets) parts.host = parts.host.substr(1, bracket - 1);
  return parts;
}

IpFamily family_of(const IpAddress& address) { return address.is_ipv4() ? IpFamily::ipv4 : IpFamily::ipv6; }

}  // namespace

std::optional<std::string> name_in(const std::string& peer) {
  std::string host = parts_of(peer).host;
  if (host.empty() || parse_ip_address(host)) return std::nullopt;
  return host;
}

std::vector<std::string> in_numbers(const std::string& peer, IpFamily family, const KnownHosts& hosts) {
  const Parts parts = parts_of(peer);
  if (const auto number = parse_ip_address(parts.host)) {
    if (family_of(*number) != family) return {};
    return {peer};
  }
  std::vector<std::string> numbers;
  const auto known = hosts.find(parts.host);
  if (known == hosts.end()) return {};
  for (const IpAddress& address : known->second) {
    if (family_of(address) != family) continue;
    const std::string text = family == IpFamily::ipv4 ? format(address) : "[" + format(address) + "]";
    numbers.push_back(parts.transport + text + parts.port);
  }
  return numbers;
}

PeerAddresses::PeerAddresses(const std::vector<std::string>& peers, ThreadSettings threads, Ask ask)
    : threads_(std::move(threads)), ask_(std::move(ask)) {
  for (const std::string& peer : peers) {
    if (std::optional<std::string> name = name_in(peer)) {
      hosts_.try_emplace(*std::move(name));
    } else {
      numbers_.push_back(peer);
    }
  }
}

void PeerAddresses::used_on(std::optional<IpFamily> family) {
  if (std::exchange(family_, family) != family) network_changed();
}

void PeerAddresses::network_changed() {
  for (auto& [name, host] : hosts_) host.is_due = true;
}

/// Begins a lookup. At most one lookup of a name runs at a time. If the network changes during a lookup,
/// the answer is used, and then the name is looked up again.
void PeerAddresses::begin(const std::string& name, Host& host, Time now) {
  host.is_due = false;
  host.asked_at = now;
  const auto lookup = [mailbox = mailbox_, ask = ask_, name, family = *family_] {
    Answer answer{name, family, ask(name, family)};
    const Lock lock(mailbox->mutex);
    mailbox->answers.push_back(std::move(answer));
    mailbox->came.notify_all();
  };
  auto thread = start_thread(ThreadSpec("name", threads_), lookup);
  if (thread) return thread->detach();
  take({name, *family_, tl::unexpected(thread.error())}, now);
}

/// Takes the answer of a lookup. Returns true if the known addresses have changed.
bool PeerAddresses::take(Answer answer, Time now) {
  Host& host = hosts_.at(answer.name);
  host.asked_at.reset();
  if (answer.family != family_) return false;
  if (!answer.addresses) {
    host.why_not = answer.addresses.error().message;
    host.retry.failed(host.why_not, now);
    return false;
  }
  host.why_not.clear();
  host.retry.succeeded();
  host.next = now + ask_again_after;
  std::vector<IpAddress>& addresses = *answer.addresses;
  if (addresses.size() > addresses_max) addresses.resize(addresses_max);
  return std::exchange(known_[answer.name], addresses) != addresses;
}

bool PeerAddresses::take_answers(Time now) {
  std::vector<Answer> answers;
  {
    const Lock lock(mailbox_->mutex);
    answers.swap(mailbox_->answers);
  }
  bool is_changed = false;
  for (Answer& answer : answers) is_changed |= take(std::move(answer), now);
  return is_changed;
}

PeerAddresses::Look PeerAddresses::look_after(Time now) {
  Look look;
  look.addresses_changed = take_answers(now);
  for (auto& [name, host] : hosts_) {
    const bool is_due = host.is_due || (now >= host.next && host.retry.due(now));
    if (!host.asked_at && is_due && family_) begin(name, host, now);
    if (host.asked_at) {
      const auto asked_for = std::chrono::duration_cast<std::chrono::milliseconds>(now - *host.asked_at);
      if (asked_for >= usual_answer && host.why_not.empty() && !known_.contains(name))
        host.why_not = "the lookup of its address has not been answered yet";
      look.next = std::min(look.next, now + std::clamp(asked_for / 2, answer_pause_min, answer_pause_max));
    } else if (family_) {
      look.next = std::min(look.next, std::max(host.next, host.retry.next()));
    }
  }
  std::vector<std::string> warnings = this->warnings();
  std::ranges::copy_if(warnings, std::back_inserter(look.news), [&](const std::string& text) {
    return std::ranges::find(last_warnings_, text) == last_warnings_.end();
  });
  look.warnings_changed = warnings != last_warnings_;
  last_warnings_ = std::move(warnings);
  return look;
}

void PeerAddresses::wait_for_answers(Time deadline) {
  const auto under_way =
      std::ranges::count_if(hosts_, [](const auto& entry) { return entry.second.asked_at.has_value(); });
  Lock lock(mailbox_->mutex);
  while (std::ssize(mailbox_->answers) < under_way && mailbox_->came.wait_until(lock, deadline)) continue;
}

std::string PeerAddresses::warning_about(const std::string& name, const Host& host) const {
  return "the peer " + in_quotes(name) + " is " +
         (known_.contains(name) ? "looked for at its last known address: " : "not looked for yet: ") +
         host.why_not;
}

std::vector<std::string> PeerAddresses::warnings() const {
  std::vector<std::string> texts;
  if (!family_) return texts;
  for (const auto& [name, host] : hosts_) {
    if (!host.why_not.empty()) texts.push_back(warning_about(name, host));
  }
  for (const std::string& peer : numbers_) {
    if (in_numbers(peer, *family_, {}).empty())
      texts.push_back("the peer " + in_quotes(peer) + " is not looked for: discovery uses " +
                      (family_ == IpFamily::ipv4 ? "IPv4" : "IPv6") + " on this host");
  }
  return texts;
}

}  // namespace sft::core
