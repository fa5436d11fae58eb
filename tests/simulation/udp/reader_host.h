// The process of the readers: takes datagrams, reassembles samples, hands them to its readers, and answers
// the writer. It can crash and be started again.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/negotiation/accepted_requests.h"
#include "core/seam/buffer_pool.h"
#include "tests/simulation/udp/laws.h"
#include "tests/simulation/udp/network.h"
#include "tests/simulation/udp/scenario.h"
#include "tests/simulation/udp/topic.h"
#include "udp_transport/flow/receive_shares.h"
#include "udp_transport/receive/reassembly.h"
#include "udp_transport/receive/subscriptions.h"
#include "udp_transport/wire/datagram.h"

namespace sft::simulation {

class ReaderHost {
 public:
  /// The arguments outlive this object.
  ReaderHost(const Scenario& scenario, Random& random, Network& network, Laws& laws)
      : scenario_(scenario), random_(random), network_(network), laws_(laws) {}

  /// Starts the process, with new readers.
  void start();
  void crash();

  /// The wishes of the readers, as the writer knows them.
  std::map<core::EndpointId, Wish> wishes_known() const;
  /// A reader asks for something else. It takes samples under both selections from now on, and the writer
  /// gets to know later.
  void change_a_wish(Time now);
  /// Another reader joins, or one leaves, but not the first one. The writer gets to know later.
  void come_or_go(Time now);
  /// How often a reader has changed its wish, has joined or has left.
  std::size_t changes() const { return changes_; }
  /// Fails if more is kept than what the present readers may need.
  void check_kept();
  /// The writer gets to know what readers have asked for long enough ago.
  void notify_writer_of_wishes(Time now);

  void receive(const Bytes& bytes, Time now);
  /// Hands over samples for which readers had no room before, and sends the answers that are due.
  void look(Time now);
  /// The time when there is something to do without a datagram.
  Time next() const;
  /// Null while the process is away.
  udp::ArrivalWindow* arrivals() { return reassembly_ == nullptr ? nullptr : reassembly_->window(0); }

 private:
  struct Reader {
    core::EndpointId id = 0;
    std::shared_ptr<udp::Inbox> inbox;  ///< the subscriptions know the reader by it; nothing is queued
    core::AcceptedRequests requests;
    Wish asked = 0;                                 ///< its latest wish
    std::optional<Wish> known{};                    ///< the wish of which the writer knows
    std::deque<std::pair<Time, Wish>> under_way{};  ///< the wishes of which the writer will know, and when
  };

  /// A reader that has left, of which the writer still knows.
  struct Departed {
    core::EndpointId id = 0;
    Wish known = 0;
    Time until;
  };

  Reader& add_reader(Wish wish);
  Wish any_wish();
  void join(Time now);
  void leave(Time now);
  void announce(Reader& reader, Time now);
  void follow();
  void accept(const Bytes& bytes, Time now);
  std::set<std::uint64_t> awaited_of(const std::optional<udp::Datagram>& datagram);
  void refuse(const std::optional<udp::Datagram>& datagram, const std::set<std::uint64_t>& awaited);
  bool has_decided(const udp::ChannelMark& mark, std::uint64_t behind);
  void report(const Bytes& bytes, Time now);
  void hand_over(Time now);
  std::size_t room_now();
  void answer(Time now);

  const Scenario& scenario_;
  Random& random_;
  Network& network_;
  Laws& laws_;
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{64} << 20);
  std::unique_ptr<udp::SubscriptionDirectory> directory_;
  std::shared_ptr<const udp::Subscriptions> subscriptions_;
  std::unique_ptr<udp::Reassembly> reassembly_;  ///< null while the process is away
  std::unique_ptr<udp::ReceiveShares> shares_;
  std::vector<Reader> readers_;
  std::vector<Departed> departed_;
  core::EndpointId last_id_ = 0;
  std::size_t changes_ = 0;
  Time look_again_at_ = Time::max();  ///< readers that had no room may have some then
};

}  // namespace sft::simulation
