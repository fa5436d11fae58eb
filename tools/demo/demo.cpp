#include "tools/demo/demo.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/demo/clouds/scene.h"
#include "tools/demo/screen/measurement.h"
#include "tools/demo/screen/report.h"

namespace sft::demo {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr seconds timeout_for_matching{20};
constexpr seconds timeout_for_shared_memory{8};
constexpr seconds timeout_for_arrival{2};
// After DDS participants have found each other, they repeat their announcements for about this long.
// Meanwhile the daemons that the hosts had to start become ready, and nodes announce that.
constexpr milliseconds settling{5'000};
constexpr const char* stopped_early = "stopped before anything was published, so there are no figures";
constexpr milliseconds refresh{250};
constexpr milliseconds poll_interval{20};
constexpr milliseconds between_notices{200};

/// Returns null if the publisher does not know such a reader.
const ReaderReport* reader_called(const PublisherReport& publisher, const std::string& name) {
  const auto reader = std::find_if(publisher.readers.begin(), publisher.readers.end(),
                                   [&](const ReaderReport& r) { return r.node == name; });
  return reader == publisher.readers.end() ? nullptr : &*reader;
}

std::uint64_t withheld_from(const PublisherReport& publisher, const std::string& name) {
  const ReaderReport* reader = reader_called(publisher, name);
  return reader == nullptr ? 0 : reader->withheld;
}

}  // namespace

Result<RunFigures> Demo::run() {
  return await_readiness()
      .and_then([this] { return let_it_settle(); })
      .and_then([this] { return publish(); })
      .and_then([this] { return await_arrival(); })
      .map([this] { return figures(last_); });
}

bool Demo::stop_asked_before(Clock::time_point then) {
  const bool asked = stop_.wait_for(then - Clock::now());
  stop_.forget();
  return asked;
}

Result<void> Demo::wait_until(Clock::time_point then, const std::string& what) {
  for (;;) {
    const auto now = Clock::now();
    display_.waiting(what, now);
    if (stop_asked_before(std::min(then, now + between_notices)))
      return fail(Errc::unavailable, stopped_early);
    if (now >= then) return {};
  }
}

Result<Demo::Snapshot> Demo::look(const Order& order, bool says_so) {
  const auto waiting = [&](const std::string& name) -> WhileWaiting {
    if (!says_so) return {};
    return [this, what = "Waiting until the " + name + " has started"] { return wait_until({}, what); };
  };
  Snapshot now;
  for (const Stage::Subscriber& subscriber : stage_.subscribers()) {
    Result<SubscriberReport> report = stage_.ask(subscriber, waiting(subscriber.name));
    if (!report) return tl::unexpected(report.error());
    now.subscribers.push_back(std::move(*report));
  }
  // The publisher is asked last, so that it counts all samples that subscribers have received by now.
  Result<PublisherReport> report = stage_.ask_publisher(order, waiting("lidar"));
  if (!report) return tl::unexpected(report.error());
  now.publisher = std::move(*report);
  now.at = Clock::now();
  return now;
}

bool Demo::served_as_wished(const Snapshot& now, std::size_t number, bool any_transport) const {
  const Stage::Subscriber& subscriber = stage_.subscribers()[number];
  const ReaderReport* reader = reader_called(now.publisher, subscriber.name);
  if (reader == nullptr || !reader->served || !now.subscribers[number].matched) return false;
  return any_transport || !subscriber.local ||
         (reader->transport == "shm" && now.subscribers[number].transport == "shm");
}

Error Demo::not_ready(const Snapshot& now) const {
  std::string text = fmt::format("not everybody was served within {} s:", timeout_for_matching.count());
  for (std::size_t i = 0; i < now.subscribers.size(); ++i) {
    if (served_as_wished(now, i, true)) continue;
    const SubscriberReport& report = now.subscribers[i];
    const std::string& why = report.warning.empty() ? report.reason : report.warning;
    text +=
        fmt::format(" {} ({})", stage_.subscribers()[i].name, why.empty() ? "heard of no publisher" : why);
  }
  if (!now.publisher.warning.empty()) text += "; the publisher says: " + now.publisher.warning;
  return {Errc::unavailable, text};
}

/// Returns the names of the subscribers that are not served yet: "health, localiser".
std::string Demo::missing(const Snapshot& now, bool any_transport) const {
  std::string names;
  for (std::size_t i = 0; i < now.subscribers.size(); ++i) {
    if (served_as_wished(now, i, any_transport)) continue;
    names += (names.empty() ? "" : ", ") + stage_.subscribers()[i].name;
  }
  return names;
}

void Demo::introduce() const {
  display_.say(fmt::format("  lidar    publishes clouds of {} x {} points, {:g} a second", Scene::rows,
                           Scene::columns, options_.hz));
  for (const Stage::Subscriber& subscriber : stage_.subscribers()) {
    const std::string host = stage_.real_hosts() ? subscriber.host : subscriber.local ? "shared" : "by UDP";
    display_.say(fmt::format("  {:<8} {:<9} {}", host, subscriber.name, subscriber.purpose));
  }
}

Result<void> Demo::await_readiness() {
  introduce();
  const auto start = Clock::now();
  Result<Snapshot> now = look({}, true);
  for (;; now = look()) {
    if (!now) return tl::unexpected(now.error());
    const auto waited = now->at - start;
    const bool any_transport = waited > timeout_for_shared_memory;
    const std::string missing_names = missing(*now, any_transport);
    if (missing_names.empty()) {
      display_.say(fmt::format("All {} subscribers found the publisher within {:.1f} s.",
                               now->subscribers.size(), std::chrono::duration<double>(waited).count()));
      for (const std::string& line : format_refusals(now->publisher)) display_.say(line);
      return {};
    }
    if (waited > timeout_for_matching) return tl::unexpected(not_ready(*now));
    const Result<void> waiting = wait_until(now->at + poll_interval, "Not served yet: " + missing_names);
    if (!waiting) return waiting;
  }
}

Result<void> Demo::let_it_settle() {
  if (!stage_.real_hosts()) return {};
  return wait_until(Clock::now() + settling, fmt::format("Waiting until discovery is quiet, {} s",
                                                         std::chrono::floor<seconds>(settling).count()));
}

Result<void> Demo::publish() {
  Result<Snapshot> now = look({Order::Kind::publish, options_.hz, options_.samples()});
  if (!now) return tl::unexpected(now.error());
  begin_ = std::move(*now);
  last_ = begin_;
  while (!last_.publisher.finished) {
    const bool stop = stop_asked_before(last_.at + refresh);
    now = look({stop ? Order::Kind::halt : Order::Kind::report});
    if (!now) return tl::unexpected(now.error());
    last_ = std::move(*now);
    display_.show(figures(last_), std::chrono::duration<double>(last_.at - begin_.at).count());
  }
  return {};
}

Result<void> Demo::await_arrival() {
  const auto deadline = Clock::now() + timeout_for_arrival;
  for (;;) {
    Result<Snapshot> now = look();
    if (!now) return tl::unexpected(now.error());
    last_ = std::move(*now);
    bool all_there = true;
    for (std::size_t i = 0; i < last_.subscribers.size(); ++i) {
      const SubscriberReport& s = last_.subscribers[i];
      const std::uint64_t withheld = withheld_from(last_.publisher, stage_.subscribers()[i].name);
      all_there = all_there && s.received + s.lost + withheld >= last_.publisher.published;
    }
    is_over_ = all_there || last_.at > deadline || stop_asked_before(last_.at + poll_interval);
    if (is_over_) return {};
  }
}

RunFigures Demo::figures(const Snapshot& now) const {
  RunFigures run;
  run.hz = options_.hz;
  run.samples = now.publisher.published;
  run.dropped = now.publisher.dropped;
  run.hosts = stage_.hosts();
  for (std::size_t i = 0; i < now.subscribers.size(); ++i) {
    const Stage::Subscriber& who = stage_.subscribers()[i];
    const Conditions conditions{options_.arr, stage_.real_hosts(), is_over_,
                                withheld_from(now.publisher, who.name)};
    SubscriberFigures subscriber =
        measure(begin_.subscribers[i], now.subscribers[i], now.publisher.published, conditions);
    subscriber.name = who.name;
    subscriber.max_rate_hz = who.max_rate_hz;
    subscriber.host = stage_.real_hosts() ? who.host : "-";
    subscriber.full_bytes_per_sample = static_cast<double>(now.publisher.full_bytes);
    run.subscribers.push_back(std::move(subscriber));
  }
  return run;
}

}  // namespace sft::demo
