// Whom a writer serves, grouped by mask and maximum rate; and the numbers that these have on the wire.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "core/seam/transport.h"
#include "sft/detail/project.h"
#include "udp_transport/flow/destination.h"
#include "udp_transport/reliable/channel_directory.h"
#include "udp_transport/reliable/lane.h"
#include "udp_transport/routing/group_keeper.h"

namespace sft::udp {

/// Readers with equal masks and limits: they share an encoding, and each destination has a lane of its own. A
/// late reader is served apart, so that what it gets can begin with what was retained.
struct Group {
  detail::ProjectionPlan plan;
  std::shared_ptr<const core::RateGate> gate;  ///< null: every sample is for them
  core::EndpointId late_reader = 0;            ///< 0: it serves others
  bool spare = false;                          ///< only for samples that are meant for spare routes, too
  std::shared_ptr<const WireMask> wire;
  std::vector<std::shared_ptr<Lane>> lanes;
  std::vector<std::shared_ptr<Channel>>
      channels{};  ///< of each lane: not null where a reader is served reliably
  /// Not null: it sends to all of them, and lanes only to those that do not hear it. Members are as lanes.
  std::shared_ptr<MulticastGroup> multicast{};
  std::shared_ptr<core::DeliveryTally> tally = std::make_shared<core::DeliveryTally>();
  /// Small samples that are published together may share datagrams: all of them leave before the first one of
  /// another mask. Where a destination is sent several masks, a reader that changes from one to the other
  /// would miss some.
  bool packs = false;

  /// The publisher's thread: the one at hand.
  bool wants_sample() const { return gate == nullptr || gate->passes(); }
};

/// Immutable: a change of routes makes another one.
struct RouteTable {
  std::vector<Group> groups;      ///< spare ones last
  core::DeliveryBook::Page page;  ///< which tallies are whose
  /// To whom these lead, but for spare ones.
  std::map<core::EndpointId, std::shared_ptr<Lane>> lanes_of;

  std::size_t usual = 0;               ///< groups that are not spare
  std::shared_ptr<BodySizes> sizes{};  ///< to be measured; null: nobody asks

  /// Whom a sample may be for.
  std::span<const Group> reached(bool with_spares) const {
    return std::span(groups).first(with_spares ? groups.size() : usual);
  }
  /// The group of a late reader; null if there is none.
  const Group* of_late_reader(core::EndpointId reader) const;
};

/// What readers ask of a writer, and asked for before: each has its number and its lanes, so that its samples
/// stay in order while routes change; a late reader has one lane whatever it asks for. Numbers are reused
/// only after all others were used in between.
class VariantDirectory {
 public:
  struct Variant {
    core::Wanted wanted;
    core::EndpointId late_reader;  ///< 0: for others
    std::shared_ptr<const WireMask> wire;
    std::vector<std::shared_ptr<Lane>> lanes;
    std::uint64_t last_use;
  };

  /// `channels` outlives it; null: nobody is served reliably.
  VariantDirectory(std::size_t queue_depth, std::shared_ptr<WriterTally> tally,
                   ChannelDirectory* channels = nullptr);

  /// The variant for that, known or new. Valid until the next call.
  Variant& find(const core::Wanted& wanted, core::EndpointId late_reader = 0);
  /// Its lane to that destination, known or new.
  std::shared_ptr<Lane> lane(Variant& variant, const std::shared_ptr<Destination>& to,
                             const std::shared_ptr<Channel>& channel = {});
  /// For all readers there that are served reliably; null where none can be.
  std::shared_ptr<Channel> channel(const std::shared_ptr<Destination>& to,
                                   const std::set<core::EndpointId>& readers) {
    return channels_ == nullptr ? nullptr : channels_->find(to, readers);
  }
  void keep_channels_to(const ReliableReaders& readers) {
    if (channels_ != nullptr) channels_->keep_to(readers);
  }

  /// Closes and forgets all lanes but those to one of these destinations. Lanes of late readers other than
  /// these are forgotten, too, but send what they have.
  void keep_lanes_to(const std::set<const Destination*>& served,
                     const std::set<core::EndpointId>& late_readers);

  /// Nothing waits for a late reader that has a lane.
  bool late_lane_idle(core::EndpointId reader) const;

  /// Forgets the longest unused ones beyond a few; called between rounds of find().
  void next_round();

 private:
  std::uint16_t unused_number();
  std::shared_ptr<Lane> late_lane(core::EndpointId reader, const std::shared_ptr<Destination>& to,
                                  const std::shared_ptr<Channel>& channel);

  static constexpr std::size_t remembered_max = 64;
  const std::size_t queue_depth_;
  const std::shared_ptr<WriterTally> tally_;
  ChannelDirectory* const channels_;
  std::vector<Variant> variants_;
  std::map<core::EndpointId, std::shared_ptr<Lane>> late_lanes_;
  std::uint16_t next_number_ = 0;
  std::uint64_t round_ = 0;
};

/// Of a writer of `type`, which outlives the table. Routes to readers elsewhere than behind a UDP address are
/// left out. Lanes to destinations that no route leads to any more are closed. Without a keeper everybody is
/// served alone.
std::shared_ptr<const RouteTable> make_route_table(const StructType& type,
                                                   std::span<const core::Route> routes,
                                                   VariantDirectory& variants,
                                                   DestinationDirectory& destinations,
                                                   GroupKeeper* keeper = nullptr);

}  // namespace sft::udp
