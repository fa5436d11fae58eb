// One publisher and 64 readers with conditions on 16 hosts, on one bridge. Multicast groups serve hosts that
// request the same fields under the same conditions. Each reader gets exactly the samples that its conditions
// let pass, as a reference confirms. The reader counts no other sample as lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/negotiation/accepted_requests.h"
#include "core/publish/gates.h"
#include "core/subscribe/sequence_account.h"
#include "tests/support/cut_reference.h"
#include "tests/support/gate_reference.h"
#include "tests/support/test_seed.h"
#include "tests/transports/udp/bridge_fixture.h"
#include "tests/transports/udp/faulty_io.h"

namespace sft::udp {
namespace {

using test::Image;

constexpr std::size_t gated_hosts = 16, readers_per_host = 4;

/// The readers request these selections in turn. Several selections have the same fields under different
/// conditions, or different fields under the same conditions. The last two have no conditions.
const std::vector<std::string> wishes{"height, data[::2] @ height > 500",
                                      "height, data[::2] @ height <= 500",
                                      "height, data[::2] @ every 3rd",
                                      "stamp, width @ height > 500",
                                      "* @ changed(width)",
                                      "* @ changed(name) or every 5th",
                                      "data @ width == 1 and height >= 200",
                                      "name, data[100:] @ changed(height) 300",
                                      "data @ width != 1",
                                      "stamp.sec @ height < 900 and every 2nd",
                                      "data",
                                      "*"};

const TypeSupport& image_type() { return test::type_support<Image>(); }

std::uint64_t gate_of(const Selection& selection) { return core::gate_id(selection.gate_hash(), 0); }

/// Returns the image with that number. Its fields sometimes differ from those of the image before, so that
/// conditions have an effect.
Image image_of(std::uint32_t number) {
  sft::test::Random random{sft::test::test_seed() + number};
  Image image = test::make_image(random() % 3000, number);
  image.height = static_cast<std::uint32_t>(random() % 1000);
  image.width = static_cast<std::uint32_t>(random() % 3);
  image.name = random() % 4 == 0 ? "left" : "right";
  return image;
}

/// Returns the image reduced to the part that the selection requests.
Image part_of(Image image, const Selection& wanted) {
  for (const Selection::Part& part : wanted.parts())
    image.data = sft::test::cut_reference::cut(image.data, part.columns);
  return image;
}

/// A gate of the publisher, and the reference for the same conditions.
class CheckedGate {
 public:
  CheckedGate(std::shared_ptr<core::Gate> gate, const Selection& selection)
      : gate_(std::move(gate)), reference_(selection.gate().conditions) {}

  void reader_begins() { reference_.begin(); }
  void evaluate(const Image& image, std::uint64_t sequence) {
    static const std::vector<sft::test::SingleField> fields = sft::test::single_fields(image_type().type());
    const auto stamp_ns = static_cast<std::int64_t>(sequence);
    const auto source = detail::FieldSource::of_message(&image);
    gate_->consider(source, stamp_ns);
    gate_->made(source, stamp_ns);
    const sft::test::FieldValues values = sft::test::values_of(fields, &image);
    if (!reference_.holds(values, stamp_ns)) return;
    reference_.passed(values, stamp_ns);
    numbers_.emplace(sequence, static_cast<std::uint32_t>(numbers_.size() + 1));
  }
  /// Returns the number of the sample among those that have passed, or nothing if the sample has not passed.
  std::optional<std::uint32_t> number(std::uint64_t sequence) const {
    const auto found = numbers_.find(sequence);
    return found == numbers_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  std::shared_ptr<core::Gate> gate_;
  sft::test::GateReference reference_;
  std::map<std::uint64_t, std::uint32_t> numbers_;  ///< the number of each passed sample, by sequence
};

/// The gates of all wishes so far, with their references.
class CheckedGates {
 public:
  /// Assigns gates to the routes. Call opened() once the routes are in force.
  void give(std::vector<core::Route>& routes) {
    gates_.give(routes);
    for (const core::Route& route : routes)
      if (route.gate != nullptr) checked_.try_emplace(route.gate->id(), gates_.of(route), route.selection);
  }
  /// Opens the gates of the routes, which must be in force. `anew` are the ids of the gates that a reader has
  /// newly requested.
  void opened(std::vector<core::Route> routes, const std::vector<std::uint64_t>& anew) {
    core::Serving serving;
    serving.network = std::move(routes);
    gates_.open_for(serving);
    for (const std::uint64_t gate : anew)
      if (gate != 0) checked_.at(gate).reader_begins();
  }
  void evaluate(const Image& image, std::uint64_t sequence) {
    for (auto& [id, gate] : checked_) gate.evaluate(image, sequence);
  }
  bool let_pass(const Selection& wish, std::uint64_t sequence) const {
    return gate_of(wish) == 0 || checked_.at(gate_of(wish)).number(sequence);
  }
  /// Returns the number of the sample in the wish's gate, or 0 if the wish has no gate.
  std::uint32_t number(const Selection& wish, std::uint64_t sequence) const {
    return gate_of(wish) == 0 ? 0 : checked_.at(gate_of(wish)).number(sequence).value_or(0);
  }

 private:
  core::Gates gates_{image_type()};
  std::map<std::uint64_t, CheckedGate> checked_;  ///< gates by their ids
};

/// A reader, and the samples that it must receive.
class GatedReader {
 public:
  GatedReader(std::shared_ptr<core::Network> transport, core::EndpointId id, const std::string& wish,
              bool reliable)
      : id_(id),
        reliable_(reliable),
        transport_(std::move(transport)),
        address_(transport_->addresses().at(0)),
        subscriber_(std::make_unique<test::Subscriber>(*transport_, std::vector{wish}, 10'000, id)) {
    ask_for(wish);
  }

  core::EndpointId id() const { return id_; }
  void listen_to(core::EndpointId writer) {
    reliable_ ? subscriber_->listen_reliably_to(writer) : subscriber_->listen_to(writer);
  }
  /// Changes the wish. Samples under former wishes may still arrive after that.
  void ask_for(const std::string& wish) {
    const Selection asked = test::selection_of<Image>(wish);
    const core::Wanted wanted{asked.without_rate()};
    if (asked_.empty()) requests_ = core::AcceptedRequests(wanted, reliable_);
    if (!asked_.empty()) requests_.asks_for(wanted, std::chrono::steady_clock::now());
    asked_.push_back(asked);
    asked_gates_.ask(gate_of(asked));
    subscriber_->port().accept(requests_.all());
  }
  const Selection& wish() const { return asked_.back(); }
  core::Route route() const {
    core::Route route{id_, address_, wish().without_rate()};
    route.reliable = reliable_;
    return route;
  }

  /// Records that the sample must arrive under the present wish. Samples that are not recorded count as
  /// withheld.
  void owe(std::uint64_t sequence) { owed_.push_back(sequence); }
  std::size_t owed() const { return owed_.size(); }
  /// Takes samples until all that must arrive have arrived. Returns the first error, or "" if there is none.
  std::string catch_up(const CheckedGates& gates) {
    std::string wrong;
    while (wrong.empty() && got_ < owed_.size()) {
      const auto samples = subscriber_->await_new(1);
      if (samples.empty()) return "sample " + std::to_string(owed_[got_]) + " does not come";
      for (const core::SampleHandle& sample : samples)
        if (wrong.empty()) wrong = take(*sample, gates);
    }
    return wrong;
  }

  std::uint64_t lost() const { return lost_; }
  std::uint64_t withheld() const { return withheld_; }
  /// Returns the number of missing samples between the first and the last one that had to arrive.
  std::uint64_t kept_from_it() const { return owed_.back() - owed_.front() + 1 - received_; }

 private:
  std::string take(const core::SampleBuffer& sample, const CheckedGates& gates) {
    const std::string which = "sample " + std::to_string(sample.sequence);
    const Selection* const named = named_by(sample);
    if (named == nullptr) return which + " is of something that the reader did not ask for";
    if (!gates.let_pass(*named, sample.sequence)) return which + " was withheld";
    if (gates.number(*named, sample.sequence) != sample.ordinal) return which + " has another number";
    const bool is_next = got_ < owed_.size() && owed_[got_] == sample.sequence;
    const bool is_former = named != &asked_.back() && (got_ == owed_.size() || sample.sequence < owed_[got_]);
    const bool comes_again = asked_.size() > 1 && !account_.is_new(sample);
    if (comes_again) return {};
    if (!is_next && !is_former) return which + " comes instead of " + std::to_string(owed_[got_]);
    const Image image = part_of(image_of(static_cast<std::uint32_t>(sample.sequence)),
                                sample.merged ? Selection(sample.mask) : *named);
    if (test::body_of(sample) != test::encoded_body(image, sample.mask)) return which + " has other bytes";
    const auto missing = account_.enter(sample, core::RateKeeper::writer, asked_gates_);
    lost_ += missing.lost;
    withheld_ += missing.withheld;
    ++received_;
    got_ += is_next ? 1 : 0;
    return {};
  }
  /// Returns the wish under which the sample was sent, or the latest such wish if several match.
  const Selection* named_by(const core::SampleBuffer& sample) const {
    const auto suits = [&](const Selection& wish) {
      if (gate_of(wish) != sample.gate) return false;
      return sample.merged ? sample.gate == 0 && sample.mask.contains(wish.mask())
                           : sample.mask == wish.mask() && sample.parts == wish.parts_hash();
    };
    const auto found = std::find_if(asked_.rbegin(), asked_.rend(), suits);
    return found == asked_.rend() ? nullptr : &*found;
  }

  core::EndpointId id_;
  bool reliable_;
  std::shared_ptr<core::Network> transport_;
  core::UdpAddress address_;
  std::unique_ptr<test::Subscriber> subscriber_;
  core::AcceptedRequests requests_;
  std::vector<Selection> asked_{};  ///< all wishes, the latest at the end
  core::AskedGates asked_gates_{};
  core::SequenceAccount account_{};
  std::vector<std::uint64_t> owed_{};  ///< the sequences of the samples that must arrive
  std::size_t got_ = 0;                ///< the number of these samples that have arrived
  std::uint64_t received_ = 0, lost_ = 0, withheld_ = 0;
};

/// Once the readers are in their groups, the links of reliable readers lose, repeat and swap datagrams.
class GateFanOutTest : public test::BridgeTest, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
    if (!make_bridge("") || !test::run("ip address add 10.20.0.1/24 dev bridge && ip link set bridge up"))
      GTEST_SKIP() << "no bridge can be made here";
    open_publisher();
    publisher_ = std::make_unique<test::Publisher>(*writer_, test::Publisher::usual_id, 0, book_);
    for (unsigned host = 0; host < gated_hosts; ++host)
      ASSERT_TRUE(on_host(host + 2, [&] { add_readers(host); }));
    serve();
  }
  void TearDown() override {
    readers_.clear();
    BridgeTest::TearDown();
  }

  /// Adds four processes with one reader each. The last host gets one process with four readers instead.
  void add_readers(unsigned host) {
    std::shared_ptr<core::Network> transport;
    for (std::size_t i = 0; i < readers_per_host; ++i) {
      if (transport == nullptr || host + 1 < gated_hosts) transport = open_transport();
      readers_.push_back(std::make_unique<GatedReader>(transport, readers_.size() + 1,
                                                       wishes[readers_.size() % wishes.size()], GetParam()));
      readers_.back()->listen_to(publisher_->id());
    }
  }
  std::shared_ptr<core::Network> open_transport() {
    const auto seed = static_cast<unsigned>(sft::test::test_seed() + readers_.size());
    const test::Faults faults{.loss = 0.02, .repetition = 0.01, .swap = 0.01, .only_while = &is_bad_};
    return open_udp_transport({}, test::make_pool(),
                              [=](DatagramIo io) { return test::with_faults(std::move(io), faults, seed); })
        .value();
  }
  /// Puts the readers' present wishes into force.
  void serve() {
    std::vector<core::Route> routes;
    std::vector<std::uint64_t> anew;
    std::map<core::EndpointId, std::uint64_t> asked;
    for (const auto& reader : readers_) {
      routes.push_back(reader->route());
      asked.emplace(reader->id(), reader->wish().hash());
      const auto before = served_wishes_.find(reader->id());
      if (before == served_wishes_.end() || before->second != reader->wish().hash())
        anew.push_back(gate_of(reader->wish()));
    }
    served_wishes_ = std::move(asked);
    gates_.give(routes);
    publisher_->port().set_routes(routes);
    gates_.opened(std::move(routes), anew);
  }
  void publish() {
    const Image image = image_of(++published_);
    const core::SampleHandle sample = publisher_->make(image);
    ASSERT_TRUE(sample);
    // As in a publisher, the samples that gates withhold count from the moment at which the routes take
    // effect.
    core::Transmission transmission = publisher_->port().begin();
    gates_.evaluate(image, published_);
    for (const auto& reader : readers_)
      if (gates_.let_pass(reader->wish(), published_)) reader->owe(published_);
    std::move(transmission).send(sample);
    writer_->poll(std::chrono::steady_clock::now());
  }
  void catch_up() {
    for (const auto& reader : readers_) ASSERT_EQ(reader->catch_up(gates_), "") << "reader " << reader->id();
  }
  /// Over good links, publishes each sample after all earlier ones have arrived, so that no queue is ever
  /// full. Over bad links, many samples are under way at the same time.
  void publish_and_compare(std::size_t samples) {
    for (std::size_t i = 0; i < samples && !HasFatalFailure(); ++i) {
      publish();
      if (!is_bad_ || published_ % 64 == 0) catch_up();
    }
  }
  /// Returns the number of wishes with conditions for which groups serve all readers that may be in one.
  std::size_t gated_groups() {
    std::map<std::uint64_t, bool> by_group;  // whether groups serve all readers of the wish, by wish
    for (const auto& reader : readers_) {
      if (gate_of(reader->wish()) == 0 || reader->id() > (gated_hosts - 1) * readers_per_host) continue;
      by_group.try_emplace(reader->wish().hash(), true).first->second &= hears(reader->id());
    }
    return static_cast<std::size_t>(
        std::ranges::count_if(by_group, [](const auto& wish) { return wish.second; }));
  }
  /// Publishes until as many groups are in use as possible: there are ten wishes with conditions, but a link
  /// has at most eight groups with conditions.
  void come_together() {
    constexpr std::size_t most_groups = 8;
    ASSERT_TRUE(test::eventually([&] {
      publish_and_compare(1);
      return HasFatalFailure() || gated_groups() == most_groups;
    })) << gated_groups()
        << " groups; " << publisher_->port().multicast(1);
    is_bad_ = GetParam();
  }
  void expect_nothing_lost() {
    for (const auto& reader : readers_) {
      EXPECT_EQ(reader->lost(), 0U) << "reader " << reader->id();
      EXPECT_EQ(reader->withheld(), reader->kept_from_it()) << "reader " << reader->id();
    }
  }

  const std::shared_ptr<core::DeliveryBook> book_ = std::make_shared<core::DeliveryBook>();
  CheckedGates gates_;
  std::atomic<bool> is_bad_{false};
  std::vector<std::unique_ptr<GatedReader>> readers_;

 private:
  std::map<core::EndpointId, std::uint64_t> served_wishes_;
};

INSTANTIATE_TEST_SUITE_P(Each, GateFanOutTest, testing::Bool(),
                         [](const auto& param) { return param.param ? "Reliable" : "BestEffort"; });

TEST_P(GateFanOutTest, GivesSixtyFourReadersJustWhatTheirOwnConditionsLetPass) {
  SCOPED_TRACE(sft::test::how_to_repeat());
  ASSERT_NO_FATAL_FAILURE(come_together());
  ASSERT_NO_FATAL_FAILURE(publish_and_compare(200));
  ASSERT_NO_FATAL_FAILURE(catch_up());
  expect_nothing_lost();
  for (const auto& reader : readers_) {
    const auto counts = [&] { return book_->of(reader->id()); };
    EXPECT_TRUE(test::eventually([&] { return counts().sent == reader->owed(); }))
        << counts().sent << " of " << reader->owed() << " count as sent to reader " << reader->id();
    EXPECT_EQ(counts().withheld, published_ - reader->owed()) << "from reader " << reader->id();
    EXPECT_EQ(counts().dropped, 0U);
  }
}

/// Each change removes a reader from its group. The next sample passes the new gate for all readers of the
/// gate.
TEST_P(GateFanOutTest, MissesNothingForReadersThatChangeTheirConditionsNorForThoseBesideThem) {
  SCOPED_TRACE(sft::test::how_to_repeat());
  sft::test::Random random{sft::test::test_seed()};
  ASSERT_NO_FATAL_FAILURE(come_together());
  for (int round = 0; round < 25; ++round) {
    for (int i = 0; i < 4; ++i)
      readers_[random() % ((gated_hosts - 1) * readers_per_host)]->ask_for(wishes[random() % wishes.size()]);
    serve();
    ASSERT_NO_FATAL_FAILURE(publish_and_compare(3)) << "round " << round;
  }
  ASSERT_NO_FATAL_FAILURE(publish_and_compare(50));
  ASSERT_NO_FATAL_FAILURE(catch_up());
  for (const auto& reader : readers_) EXPECT_EQ(reader->lost(), 0U) << "reader " << reader->id();
}

}  // namespace
}  // namespace sft::udp
