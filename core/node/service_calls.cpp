#include "sft/detail/service_calls.h"

#include <limits>

#include "core/platform/random_id.h"
#include "core/subscribe/subscriber_core.h"

namespace sft::detail {

namespace {

using namespace std::chrono_literals;

constexpr std::chrono::nanoseconds first_pause = 100ms;  // the time after which a call is first repeated
constexpr std::chrono::nanoseconds longest_pause = 1s;
constexpr std::chrono::nanoseconds look_for_server = 20ms;
constexpr std::chrono::nanoseconds look_whether_it_lives = 100ms;
constexpr std::chrono::nanoseconds longest_timeout = std::chrono::hours(24 * 365);

std::string text_of(std::chrono::nanoseconds time) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
  return ms % 1000 == 0 ? std::to_string(ms / 1000) + " s" : std::to_string(ms) + " ms";
}

}  // namespace

// Returns the topic of calls. If the service has no name, the result is empty, and not "/call".
std::string call_topic(std::string_view service) {
  return service.empty() ? "" : std::string(service) + "/call";
}
std::string reply_topic(std::string_view service) {
  return service.empty() ? "" : std::string(service) + "/reply";
}

std::uint64_t new_client_id() {
  for (;;) {
    if (const std::uint64_t id = core::random_id(); id != 0) return id;
  }
}

bool in_sample_callback() { return core::SubscriberCore::in_callback(); }

std::vector<SeenServer> seen_servers(const PublisherStatus& calls, const SubscriberStatus& replies) {
  std::vector<SeenServer> seen;
  for (const SubscriberStatus::Writer& writer : replies.writers) {
    // Other programs, such as `sft echo`, may receive the calls, too. If the node of such a program has the
    // same name as the server's node, a call may be sent too early. The call is repeated later.
    const auto hears = [&](const PublisherStatus::Reader& r) { return r.served && r.node == writer.node; };
    const bool is_heard = std::ranges::any_of(calls.readers, hears);
    seen.push_back({.id = writer.id,
                    .node = writer.node,
                    .matched = writer.matched && writer.alive,
                    .connected = writer.connected && is_heard,
                    .reason = writer.connected ? "calls do not reach it yet" : writer.reason});
  }
  return seen;
}

const SeenServer* only_server(const std::vector<SeenServer>& seen) {
  const auto found = std::ranges::find_if(seen, &SeenServer::matched);
  if (found == seen.end() || std::ranges::count_if(seen, &SeenServer::matched) != 1) return nullptr;
  return found->connected ? &*found : nullptr;
}

ClientCall::ClientCall(std::string_view service, ServiceTime now, std::chrono::nanoseconds timeout)
    : prefix_("service '" + std::string(service) + "': "),
      timeout_(std::clamp<std::chrono::nanoseconds>(timeout, 0ns, longest_timeout)),
      deadline_(now + timeout_),
      pause_(first_pause) {}

ClientCall::Step ClientCall::next(ServiceTime now, const std::vector<SeenServer>& seen) {
  const bool was_sent = server_.id != 0;
  if (was_sent) {
    const auto still_there = [&](const SeenServer& s) { return s.id == server_.id && s.matched; };
    if (std::ranges::none_of(seen, still_there)) {
      return failed("its server, on node '" + server_.node +
                    "', has gone; whether it has carried out the call is not known");
    }
  }
  // The call is sent to an existing server at least once, even if this thread runs late.
  const SeenServer* const only = was_sent ? nullptr : only_server(seen);
  if (now >= deadline_ && only == nullptr) return failed(why_late(seen));
  if (only != nullptr) {
    server_ = *only;
    next_ = now;
  }
  if (server_.id == 0) return {.kind = Step::Kind::wait, .until = std::min(deadline_, now + look_for_server)};
  if (now < next_)
    return {.kind = Step::Kind::wait, .until = std::min({deadline_, next_, now + look_whether_it_lives})};
  next_ = now + pause_;
  pause_ = std::min(2 * pause_, longest_pause);
  return {.kind = Step::Kind::send, .server = server_.id};
}

std::uint32_t ClientCall::timeout_ms() const {
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(timeout_).count();
  return static_cast<std::uint32_t>(std::min<std::int64_t>(ms, std::numeric_limits<std::uint32_t>::max()));
}

std::string ClientCall::why_late(const std::vector<SeenServer>& seen) const {
  const std::string late = " within " + text_of(timeout_);
  if (server_.id != 0) return "the server on node '" + server_.node + "' did not answer" + late;
  if (seen.empty()) return "no server was there" + late;
  std::string nodes;
  for (const SeenServer& server : seen) {
    if (server.matched) nodes += (nodes.empty() ? "'" : ", '") + server.node + "'";
  }
  if (std::ranges::count_if(seen, &SeenServer::matched) > 1) {
    return "there is more than one server, on the nodes " + nodes +
           ": end all but one; one that was killed is noticed after some seconds";
  }
  const auto worst =
      std::ranges::find_if(seen, [](const SeenServer& s) { return !s.matched || !s.connected; });
  const SeenServer& server = worst == seen.end() ? seen.front() : *worst;
  return "the server on node '" + server.node + "' could not be called" + late + ": " + server.reason;
}

}  // namespace sft::detail
