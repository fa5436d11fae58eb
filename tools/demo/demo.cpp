#include "tools/demo/demo.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/demo/screen/report.h"

namespace sft::demo {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr seconds patience_for_matching{20};
constexpr seconds patience_for_shared_memory{8};
constexpr seconds patience_for_arrival{2};
constexpr milliseconds refresh{250};
constexpr milliseconds moment{20};

double seconds_of(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

Result<RunFigures> Demo::run() {
  introduce();
  return await_readiness()
      .and_then([this] { return publish(); })
      .and_then([this] { return await_arrival(); })
      .map([this] { return figures(true); });
}

void Demo::introduce() const {
  display_.say(
      fmt::format("  lidar    publishes clouds of {}, {:g} a second", setting_.message_shape, setting_.hz));
  for (const Stage::Subscriber& subscriber : stage_.subscribers()) {
    const std::string host = stage_.real_hosts() ? subscriber.host : subscriber.local ? "shared" : "by UDP";
    display_.say(fmt::format("  {:<8} {:<9} {}", host, subscriber.name, subscriber.purpose));
  }
}

bool Demo::stop_asked() {
  const bool asked = stop_.requested();
  stop_.forget();
  return asked;
}

Result<void> Demo::wait_a_moment() {
  stop_.wait_for(moment);
  return stage_.update();
}

Result<void> Demo::await_readiness() {
  const auto start = Clock::now();
  for (;;) {
    if (const Result<void> go_on = wait_a_moment(); !go_on) return go_on;
    const auto waited = Clock::now() - start;
    std::string names;
    std::string reasons;
    for (const Stage::Subscriber& s : stage_.subscribers()) {
      const bool as_wished = s.route.in_shared_memory == s.local || waited > patience_for_shared_memory;
      if (s.report.open && s.route.served && as_wished) continue;
      names += (names.empty() ? "" : ", ") + s.name;
      reasons += " " + s.name + " (" + (s.report.open ? s.route.reason.str() : "it has not started") + ")";
    }
    if (names.empty()) {
      display_.say(fmt::format("All {} subscribers found the publisher within {:.1f} s.",
                               stage_.subscribers().size(), seconds_of(waited)));
      const Route& local = stage_.subscribers().back().route;
      if (!local.in_shared_memory) display_.say("The detector is served by UDP: " + local.reason.str() + ".");
      return {};
    }
    if (stop_asked())
      return fail(Errc::unavailable, "stopped before anything was published, so there are no figures");
    if (waited > patience_for_matching) {
      return fail(Errc::unavailable,
                  fmt::format("not all were served within {} s:{}", patience_for_matching.count(), reasons));
    }
    display_.waiting("Not served yet: " + names);
  }
}

Result<void> Demo::publish() {
  stage_.order(Order::publish);
  const auto start = Clock::now();
  auto next_look = start + refresh;
  while (!stage_.publisher().finished) {
    if (const Result<void> go_on = wait_a_moment(); !go_on) return go_on;
    if (stop_asked()) stage_.order(Order::halt);
    const auto now = Clock::now();
    if (now < next_look) continue;
    next_look = now + refresh;
    display_.show(figures(false), seconds_of(now - start));
  }
  return {};
}

Result<void> Demo::await_arrival() {
  const auto deadline = Clock::now() + patience_for_arrival;
  while (!all_arrived() && Clock::now() < deadline && !stop_asked()) {
    if (const Result<void> go_on = wait_a_moment(); !go_on) return go_on;
  }
  return {};
}

bool Demo::all_arrived() const {
  return std::ranges::all_of(stage_.subscribers(), [&](const Stage::Subscriber& s) {
    return s.report.received + s.report.lost + s.route.withheld >= stage_.publisher().published;
  });
}

RunFigures Demo::figures(bool is_over) const {
  RunFigures run = setting_;
  run.samples = stage_.publisher().published;
  run.whole_bytes = stage_.publisher().whole_bytes;
  run.hosts = stage_.hosts();
  for (const Stage::Subscriber& s : stage_.subscribers()) {
    SubscriberFigures figures{.name = s.name, .route = s.route, .counts = s.report};
    // A subscriber cannot know about samples after the last one that it received.
    const std::uint64_t came = s.report.received + s.route.withheld;
    if (is_over) figures.counts.lost = std::max(s.report.lost, run.samples - std::min(run.samples, came));
    run.subscribers.push_back(std::move(figures));
  }
  return run;
}

}  // namespace sft::demo
