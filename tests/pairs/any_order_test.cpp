// The events of all rows of negotiation.md in random order. After any events, both sides agree in the end,
// and all samples are accounted for.
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

class AnyOrder : public NegotiationTest, public testing::WithParamInterface<int> {
 protected:
  using Event = std::function<void()>;

  /// Runs a publisher on this host and a reader on `host_of_reader`, and makes random events of the list
  /// happen.
  void run(const Host& host_of_reader, const std::vector<Event>& events) {
    host_of_reader_ = &host_of_reader;
    start_publisher();
    start_reader();
    for (int i = 0; i < 12; ++i) {
      events[random() % events.size()]();
      comes_true([&] { return is_served(*publisher_, *reader_); }, some_time());
    }
    expect_a_good_end();
  }

  const Event publisher_restarts = [this] { start_publisher(); };
  const Event reader_restarts = [this] { start_reader(); };
  const Event mask_changes = [this] { change_mask(); };
  const Event rate_changes = [this] { reader_->set_max_rate_hz(one_of(std::array{0.0, 50.0, 200.0})); };
  const Event reader_stops = [this] {
    reader_->signal(SIGSTOP);
    comes_true([&] { return !is_served(*publisher_, *reader_); }, some_time());
    reader_->signal(SIGCONT);
  };
  const Event publisher_stops = [this] {
    publisher_->signal(SIGSTOP);
    wait_until_it_is_missed();
    publisher_->signal(SIGCONT);
  };
  const Event cable_is_pulled = [this] {
    there().set_plugged(false);
    wait_until_it_is_missed();
    there().set_plugged(true);
  };
  const Event link_goes_down = [this] {
    here().set_link(false);
    wait_until_it_is_missed();
    here().set_link(true);
  };
  const Event daemon_comes_or_is_killed = [this] {
    daemon_ ? daemon_.reset() : void(daemon_.emplace(here()));
  };

 private:
  void start_publisher() {
    publisher_ = start(here());
    publisher_->advertise();
    publisher_->start_publishing();
  }
  void start_reader() {
    reader_ = start(*host_of_reader_);
    reader_->subscribe("recorded");
    change_mask();
  }
  std::unique_ptr<Peer> start(const Host& host) {
    return std::make_unique<Peer>(host, "peer_" + std::to_string(++started_), with_short_lease());
  }
  void change_mask() {
    fields_ = one_of(std::array{"height", "width", "height, width", "header.frame_id, data", "data"});
    reader_->read(fields_);
  }
  void wait_until_it_is_missed() {
    comes_true(
        [&] {
          const json entry = writer_of(*publisher_, *reader_);
          return !entry.is_null() && !entry["alive"];
        },
        some_time());
  }
  void expect_a_good_end() {
    network().set_faults({});
    reader_->set_max_rate_hz(0);
    EXPECT_TRUE(comes_true([&] { return is_served_with(*publisher_, *reader_, fields_); }))
        << fields_ << " is asked for, " << reader_of(*publisher_, *reader_) << " served";
    publisher_->stop_publishing();
    EXPECT_TRUE(agree(*publisher_, *reader_));
    EXPECT_TRUE(accounts_for_all(*publisher_, *reader_));
  }

  template <class T, std::size_t N>
  T one_of(const std::array<T, N>& choices) {
    return choices[random() % N];
  }
  /// Returns a random time, mostly less than a lease.
  std::chrono::milliseconds some_time() {
    return std::chrono::milliseconds(random() % (random() % 3 != 0 ? 200 : 3000));
  }

  std::unique_ptr<Peer> publisher_, reader_;
  std::optional<Daemon> daemon_;
  const Host* host_of_reader_ = nullptr;
  std::string fields_;
  int started_ = 0;
};

TEST_P(AnyOrder, OfWhatHappensBetweenTwoHostsEndsWell) {
  if (random() % 2 == 0) network().set_faults({.lost = 0.1, .repeated = 0.1, .delayed = 0.1});
  run(there(), {publisher_restarts, reader_restarts, mask_changes, rate_changes, publisher_stops,
                reader_stops, cable_is_pulled, link_goes_down});
}

TEST_P(AnyOrder, OfWhatHappensOnOneHostEndsWell) {
  run(here(), {publisher_restarts, reader_restarts, mask_changes, rate_changes, publisher_stops, reader_stops,
               daemon_comes_or_is_killed, daemon_comes_or_is_killed});
}

INSTANTIATE_TEST_SUITE_P(Random, AnyOrder, testing::Range(0, 3));

}  // namespace
}  // namespace sft::test
