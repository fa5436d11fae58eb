#include "tests/simulation/udp/world.h"

#include <algorithm>
#include <chrono>

#include "tests/support/parse_datagram.h"

namespace sft::simulation {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t steps_max = 200'000, steps_of_a_sample_max = 100;

/// The number of unused gates that a publisher keeps (core/publish/gates.h). The publisher removes further
/// unused gates when it serves other wishes.
constexpr std::size_t gates_remembered = 64;

}  // namespace

World::World(std::uint64_t seed, Plan plan)
    : random_(seed),
      scenario_(random_, plan),
      network_(scenario_.weather, scenario_.datagram_bytes, random_),
      laws_(scenario_),
      channel_(scenario_, random_, network_, laws_.loss_account()),
      group_(random_, network_, channel_, laws_),
      publisher_(scenario_, random_, channel_, group_, laws_),
      readers_(scenario_, random_, network_, laws_) {
  if (scenario_.crashes) crash_at_ = now_ + std::chrono::milliseconds(from_to(random_, 0, 100));
  readers_.start();
}

std::string World::run() {
  const std::size_t most = std::max(steps_max, steps_of_a_sample_max * scenario_.samples);
  for (std::size_t steps = 0; laws_.violation().empty() && step(); ++steps) {
    if (steps == most) laws_.fail("it does not come to rest");
  }
  if (laws_.violation().empty()) laws_.check_end(channel_.window(), channel_.number());
  if (laws_.violation().empty() && scenario_.asking.churn != 0) laws_.check_settled();
  if (laws_.violation().empty()) return {};
  return laws_.violation() + ", after " + std::to_string((now_ - start_time) / 1us) + " us";
}

/// Advances to the next event. Returns false if there is no event.
bool World::step() {
  const Time next = next_event();
  if (next == Time::max()) return false;
  now_ = std::max(now_, next);
  deliver();
  if (crash_at_ <= now_) crash();
  if (back_at_ <= now_) start_again();
  readers_.notify_writer_of_wishes(now_);
  group_.send_due(now_);
  if (publisher_.next() <= now_) publish();
  if (channel_.next(now_) <= now_) channel_.send(now_);
  group_.offer(now_);
  readers_.look(now_);
  if (happens(random_, scenario_.asking.change_midway) && !is_quiet()) readers_.change_a_wish(now_);
  laws_.check(channel_.window(), readers_.arrivals());
  return true;
}

Time World::next_event() const {
  return std::min({network_.next(), crash_at_, back_at_, publisher_.next(), channel_.next(now_),
                   group_.next(), readers_.next()});
}

void World::deliver() {
  while (network_.next() <= now_) {
    const Network::Datagram datagram = network_.take();
    if (datagram.to == Network::Side::reader) {
      readers_.receive(datagram.bytes, now_);
    } else if (const auto report = udp::parse_as<udp::GroupReport>(datagram.bytes)) {
      group_.hear(*report, now_);
    } else {
      channel_.hear(datagram.bytes, now_);
    }
  }
}

/// Crashes the process of the readers. The process that is started next will be served by another channel.
void World::crash() {
  crash_at_ = Time::max();
  readers_.crash();
  back_at_ = now_ + std::chrono::milliseconds(from_to(random_, 0, 50));
}

void World::start_again() {
  back_at_ = Time::max();
  channel_.open();
  group_.begin_anew();
  readers_.start();
}

void World::publish() {
  publisher_.publish(readers_.wishes_known(), now_);
  if (happens(random_, scenario_.asking.change) && !is_quiet()) readers_.change_a_wish(now_);
  if (scenario_.asking.churn != 0) churn();
  if (happens(random_, scenario_.regroup)) group_.change();
  if (happens(random_, scenario_.detour)) network_.take_detour(any_datagram_bytes(random_));
}

void World::churn() {
  if (happens(random_, scenario_.asking.churn) && !is_quiet()) readers_.come_or_go(now_);
  readers_.check_kept();
  const std::size_t in_force = readers_.wishes_known().size();
  if (publisher_.gates() > gates_remembered + in_force) laws_.fail("gates of former wishes are kept");
}

}  // namespace sft::simulation
