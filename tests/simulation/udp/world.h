// One writer, a process with some readers of it, and a network in between, from a seed: the writer's and the
// reader's end of the protocol as they are, on simulated I/O and time. What must hold is checked after each
// event, and what must have come in the end.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/negotiation/accepted_requests.h"
#include "tests/simulation/udp/network.h"
#include "tests/unit/udp/messages.h"
#include "udp_transport/flow/flow_window.h"
#include "udp_transport/flow/receive_shares.h"
#include "udp_transport/multicast/group_membership.h"
#include "udp_transport/receive/reassembly.h"
#include "udp_transport/receive/subscriptions.h"
#include "udp_transport/reliable/resend_window.h"

namespace sft::simulation {

inline constexpr core::EndpointId writer_id = 0x7'0000'0001;

/// The things that a seed decides.
struct Scenario {
  Weather weather;
  std::size_t datagram_bytes = 1472;
  std::size_t samples = 40;
  std::size_t sample_bytes_max = 20'000;
  std::uint64_t first_sequence = 1;
  std::uint64_t first_ordinal = 1;
  bool tight_writer = false;  ///< little is kept
  bool tight_reader = false;
  bool crashes = false;  ///< the process of the readers, and comes back
  double change = 0;     ///< of a mask, for each sample
  std::size_t receive_buffer_bytes = 212'992;
  double regroup = 0;        ///< of the multicast group that the process is in, for each sample
  double span = 0;           ///< several samples instead of one
  bool readers_lag = false;  ///< they take a few samples now and then, and the writer waits for them
  double detour = 0;         ///< by a path that takes datagrams of another length, for each sample
  Time stalled_from = Time::max(), stalled_until{};  ///< then nothing of the writer leaves but heartbeats
  udp::ResendLimits resend{};
  udp::ReassemblyLimits reassembly{};

  Scenario(Random& random, bool forgers);

 private:
  void beset(Random& random);
};

class World {
 public:
  /// `forgers`: in the beginning datagrams are forged, too. A second after the last one all is delivered
  /// again; what is lost until then nobody counts.
  explicit World(std::uint64_t seed, bool forgers = false);

  /// Runs until nothing happens any more. What went wrong first; empty if nothing did.
  std::string run();

 private:
  using Mask = std::size_t;  ///< its place in masks()
  static const std::vector<FieldMask>& masks();

  /// One encoding of a sample.
  struct Variant {
    std::uint64_t sequence = 0;
    std::uint64_t mask = 0;  ///< its hash
    friend auto operator<=>(const Variant&, const Variant&) = default;
  };
  struct Reader {
    core::EndpointId id = 0;
    std::shared_ptr<udp::Inbox> inbox;  ///< as which it is known; nothing is queued
    core::AcceptedRequests requests;
    Mask served = 0;                                ///< what the writer knows of these
    std::deque<std::pair<Time, Mask>> under_way{};  ///< and when it will know others
    std::uint64_t last = 0;                         ///< sequence that it got
    std::set<std::uint64_t> last_masks{};
    bool took_others = false;       ///< masks, too, when it got that
    std::vector<Variant> to_get{};  ///< what was sent to it
    std::set<std::uint64_t> got{};  ///< sequences that came
  };
  /// The samples that were sent in a channel, and what the process knows of these.
  struct Channel {
    std::map<std::uint64_t, Variant> sent{};    ///< by ordinal
    std::optional<std::uint64_t> known_from{};  ///< the ordinal that the process began with
    std::uint64_t gone_before = 0;              ///< none before it will come, as the process was told
    std::uint64_t base = 0;                     ///< place of ordinal 0
  };
  /// A sample, or a part of it, that is being cut into datagrams.
  struct Sending {
    udp::ResendWindow::Piece piece;
    udp::Fragmenter fragments;
  };

  /// A multicast group that the process is in, with others that are not looked at.
  struct Group {
    std::uint32_t number = 0;
    bool deaf = false;  ///< nothing of it comes to the process
    std::uint64_t last_ordinal = 0;
    std::optional<std::int64_t> ahead{};  ///< of these are the channel's
    udp::GroupMembership membership{};
  };
  /// A datagram that waits to be sent to a group, whether that is the present group or not.
  struct Leaving {
    Time at;
    udp::JobHandle job;
    std::uint64_t in_channel = 0;
    bool lost = false;
  };

  // The writer.
  void open_channel();
  void publish();
  void publish_to_group(const udp::test::Image& image, const FieldMask& all);
  void send_to_group();
  void send_to_group(const udp::JobHandle& job);
  void regroup();
  void offer_group();
  void hear_report(const udp::GroupReport& report);
  udp::ResendWindow::Kept keep(const udp::JobHandle& job, bool elsewhere = false);
  udp::JobHandle encode(std::span<const udp::test::Image> images, const FieldMask& mask,
                        std::uint16_t variant);
  void project(udp::Job& job, const core::SampleHandle& sample, const FieldMask& mask, bool packed);
  void send_some();
  void send_some(udp::ResendWindow::Size size);
  bool may_send(udp::ResendWindow::Size size);
  void send_mark();
  void send_heartbeat();
  void hear(const Bytes& bytes);
  void change_a_mask();
  void learn_of_masks();

  // The process of the readers.
  void start_process();
  void follow();
  void crash();
  void receive(const Bytes& bytes);
  void note_channel(const std::optional<udp::ArrivalWindow::Mark>& before,
                    const std::optional<udp::Heartbeat>& heartbeat);
  void report(const Bytes& mark);
  void answer();
  void take_at_once(const core::SampleBuffer& sample);
  void note_unwanted(const Bytes& bytes);
  void hand_over();
  std::size_t room_now();
  void get(Reader& reader, const core::SampleBuffer& sample);
  bool is_sound(const core::SampleBuffer& sample, const std::string& which);

  Time next_event() const;
  bool step();
  void check_limits();
  void check_losses();
  std::uint64_t missing_of(const Channel& channel, std::uint64_t end) const;
  void check_end();
  void check_end(const Reader& reader);
  void check_end_after_forgeries(const Reader& reader);
  void fail(const std::string& what);

  Random random_;
  const bool forgers_;
  std::uint64_t first_owed_ = 0;  ///< the first sample that was published a second after the last forgery
  const Scenario scenario_;
  Network network_;
  Time now_ = Time(std::chrono::hours(1));
  std::string failure_;

  std::shared_ptr<udp::JobPool> jobs_ = udp::JobPool::make();
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{64} << 20);
  std::unique_ptr<udp::ResendWindow> window_;
  std::unique_ptr<udp::FlowWindow> flow_;
  std::uint64_t oldest_kept_ = 1;
  std::uint32_t channel_ = 0;
  std::optional<Group> group_;
  std::uint32_t last_group_ = 0;
  std::deque<Leaving> leaving_;  ///< the oldest first
  std::optional<Sending> sending_[2];
  Time send_at_;
  std::uint64_t sequence_;
  std::size_t published_ = 0;
  std::size_t datagram_bytes_;  ///< that the path takes by now
  Time publish_at_;
  std::map<std::uint64_t, udp::test::Image> images_;
  std::map<std::uint32_t, Channel> channels_;  ///< by number
  std::set<std::uint64_t> not_kept_;           ///< sequences that had to go for others

  std::unique_ptr<udp::SubscriptionDirectory> directory_;
  std::shared_ptr<const udp::Subscriptions> subscriptions_;
  std::unique_ptr<udp::Reassembly> reassembly_;
  std::unique_ptr<udp::ReceiveShares> shares_;
  std::vector<Reader> readers_;
  std::set<Variant> came_at_once_;
  std::set<Variant> unwanted_;        ///< that came, and nobody in the process had asked for
  std::uint64_t lost_ = 0;            ///< as the process was told
  Time look_again_at_ = Time::max();  ///< whether readers that had no room have some
  Time crash_at_ = Time::max();
  Time back_at_ = Time::max();
};

}  // namespace sft::simulation
