// Readers with conditions on many hosts join, leave and change their requests several thousand times while
// samples are published. These tests check which readers share a multicast group, and that no unneeded group
// or gate remains in the end.
#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/test_seed.h"
#include "tests/unit/udp/routing/group_keeper_fixture.h"
#include "udp_transport/multicast/divisions.h"

namespace sft::udp::test {
namespace {

/// Several selections have the same conditions and different fields, or the same fields and different
/// conditions. The last three have no conditions.
const std::vector<std::string> wishes{"data @ height > 500",
                                      "data @ height <= 500",
                                      "data[::3] @ height > 500",
                                      "* @ every 2nd",
                                      "height, data @ every 2nd",
                                      "data @ every 3rd",
                                      "data[::3] @ every 3rd",
                                      "* @ changed(width)",
                                      "data @ changed(height) 300",
                                      "data[100:] @ width == 1",
                                      "data[100:] @ width != 1",
                                      "* @ height < 900 and every 2nd",
                                      "data @ every 3rd or width == 2",
                                      "data",
                                      "data[::3]",
                                      "*"};

class GatedChurnTest : public GroupKeeperTest {
 protected:
  GatedChurnTest() { anything_passes_ = false; }  // samples pass gates in evaluate() instead

  /// The number of hosts. join() adds a reader on one of them; some readers share a process.
  static constexpr std::uint32_t hosts = 200;
  void join(const std::string& wish, std::uint32_t host) {
    const std::uint32_t link = host % 4 == 0 ? second_link : first_link;
    core::Route route{++last_reader_, core::UdpAddress{link + 10 + host, 1000, 1'000'000},
                      selection_of<Image>(wish).without_rate()};
    route.reliable = random_() % 2 == 0;
    routes_.push_back(std::move(route));
  }
  /// Returns one of the wishes, or sometimes a selection that hardly any other reader has.
  std::string any_wish() {
    if (random_() % 8 == 0) return "data @ height > " + std::to_string(random_() % 1000);
    return wishes[random_() % wishes.size()];
  }
  void change() {
    const bool joins = routes_.size() < 20 || (routes_.size() < 60 && random_() % 2 == 0);
    const std::size_t place = routes_.empty() ? 0 : random_() % routes_.size();
    if (random_() % 2 == 0 && !routes_.empty()) {
      routes_[place].selection = selection_of<Image>(any_wish()).without_rate();
    } else if (joins) {
      join(any_wish(), static_cast<std::uint32_t>(random_() % hosts));
    } else {
      routes_.erase(routes_.begin() + static_cast<std::ptrdiff_t>(place));
    }
  }
  /// Puts the readers' requests into force. Readers with the same conditions share a gate.
  void put_in_force() {
    for (core::Route& route : routes_) route.gate = gate_of(route.selection);
    serve();
    note_groups();
  }
  /// Publishes a sample each millisecond, and maintains the groups as the agent does.
  void publish_for(std::chrono::milliseconds time) {
    for (const auto end = now_ + time; now_ < end; now_ += 1ms) {
      Image image = make_image(2000);
      image.height = static_cast<std::uint32_t>(random_() % 1000);
      image.width = static_cast<std::uint32_t>(random_() % 3);
      evaluate(image);
      publish(image);
      if (keeper_->replan(now_)) {
        serve();
        note_groups();
      }
      keeper_->maintain(now_);
    }
  }

  /// Expects that each reader is served once, that all readers in a group with a gate request the same part
  /// of the same samples, and that all readers in a group without a gate request every sample.
  void expect_right_groups() {
    std::map<core::EndpointId, const core::Route*> routes;
    for (const core::Route& route : routes_) routes.emplace(route.reader, &route);
    std::set<core::EndpointId> served;
    std::map<std::uint32_t, std::size_t> gated_groups;  // the number of groups with a gate, by link
    for (const RouteBundle& bundle : merged_) {
      for (const auto& [reader, to] : bundle.readers) {
        ASSERT_TRUE(served.insert(reader).second) << "reader " << reader << " is served twice";
        const core::Route& route = *routes.at(reader);
        ASSERT_TRUE(bundle.gate == route.gate) << "reader " << reader;
        ASSERT_TRUE(bundle.gate == nullptr || bundle.wanted.selection == route.selection);
        ASSERT_TRUE(bundle.wanted.selection.mask().contains(route.selection.mask()));
      }
      if (bundle.multicast && bundle.gate != nullptr)
        ++gated_groups[bundle.destinations.front()->path().address().ip.ipv4() & netmask];
    }
    ASSERT_EQ(served.size(), routes_.size());
    for (const auto& [link, count] : gated_groups) ASSERT_LE(count, some_samples_groups_max);
  }
  std::size_t gated_groups() const {
    return static_cast<std::size_t>(std::ranges::count_if(
        merged_, [](const RouteBundle& bundle) { return bundle.multicast && bundle.gate != nullptr; }));
  }
  std::size_t groups_alive() { return alive(noted_groups_); }
  std::size_t gates_alive() { return alive(gates_); }
  std::size_t gates_asked_for() const {
    std::set<const core::Gate*> gates;
    for (const core::Route& route : routes_)
      if (route.gate != nullptr) gates.insert(route.gate.get());
    return gates.size();
  }

  sft::test::Random random_{sft::test::test_seed()};

 private:
  std::shared_ptr<core::Gate> gate_of(const Selection& selection) {
    if (selection.gate().is_open()) return nullptr;
    std::weak_ptr<core::Gate>& known = gates_[selection.gate_hash()];
    std::shared_ptr<core::Gate> gate = known.lock();
    if (gate == nullptr) {
      detail::Conditions conditions(type_support<Image>().type(), selection.gate().conditions);
      gate = std::make_shared<core::Gate>(0, std::move(conditions), selection.gate_hash());
      gate->reader_begins();
      known = gate;
    }
    return gate;
  }
  void evaluate(const Image& image) {
    const auto stamp_ns = std::chrono::nanoseconds(now_.time_since_epoch()).count();
    const auto fields = detail::FieldSource::of_message(&image);
    for (const auto& [hash, known] : gates_) {
      const std::shared_ptr<core::Gate> gate = known.lock();
      if (gate == nullptr) continue;
      gate->consider(fields, stamp_ns);
      gate->made(fields, stamp_ns);
    }
  }
  void note_groups() {
    for (const auto& group : groups_) noted_groups_[group->name().number] = group;
  }
  template <class Known>
  static std::size_t alive(Known& known) {
    std::erase_if(known, [](const auto& one) { return one.second.expired(); });
    return known.size();
  }

  core::EndpointId last_reader_ = 0;
  std::map<std::uint64_t, std::weak_ptr<core::Gate>> gates_;  ///< gates by the hash of their conditions
  std::map<std::uint32_t, std::weak_ptr<MulticastGroup>> noted_groups_;
};

TEST_F(GatedChurnTest, ReadersShareAGroupOnlyIfTheyWantTheSameSamplesHoweverOftenTheyChange) {
  SCOPED_TRACE(sft::test::how_to_repeat());
  std::size_t groups = 0;
  for (std::uint64_t round = 0; round < sft::test::test_rounds(300); ++round) {
    for (std::uint64_t changes = 1 + random_() % 4; changes > 0; --changes) {
      change();
      put_in_force();
      ASSERT_NO_FATAL_FAILURE(expect_right_groups()) << "round " << round;
    }
    publish_for(std::chrono::milliseconds(random_() % 60));
    ASSERT_NO_FATAL_FAILURE(expect_right_groups()) << "round " << round;
    groups += gated_groups();
  }
  EXPECT_GT(groups, 100U) << "there were some to look at";
}

/// Farewells of removed groups and counts of removed gates are discarded in the end, too.
TEST_F(GatedChurnTest, NoGroupAndNoGateIsKeptThatNobodyNeedsAnyMore) {
  SCOPED_TRACE(sft::test::how_to_repeat());
  for (std::uint32_t host = 0; host < 64; ++host) join(wishes[host / 4], host);
  const std::vector<core::Route> at_first = routes_;
  put_in_force();
  publish_for(7s);
  const std::size_t groups = groups_.size();
  ASSERT_GT(groups, 0U);
  std::size_t changes = 0;
  for (; changes < sft::test::test_rounds(1000); ++changes) {
    change();
    put_in_force();
    publish_for(std::chrono::milliseconds(random_() % 5));
  }
  routes_ = at_first;
  put_in_force();
  EXPECT_GE(groups_alive(), groups_.size());
  publish_for(7s);
  ASSERT_NO_FATAL_FAILURE(expect_right_groups());
  EXPECT_EQ(groups_.size(), groups) << "the same as before";
  EXPECT_EQ(groups_alive(), groups_.size());
  EXPECT_EQ(gates_alive(), gates_asked_for());
  EXPECT_EQ(why(100'000), "") << "nothing is told of a reader that does not exist";
}

}  // namespace
}  // namespace sft::udp::test
