// The audiences of a writer: its readers grouped by mask and maximum rate, with the variant numbers on the
// wire.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "core/seam/transport.h"
#include "sft/detail/project.h"
#include "udp_transport/flow/destination.h"
#include "udp_transport/flow/destination_directory.h"
#include "udp_transport/reliable/channel_directory.h"
#include "udp_transport/reliable/lane.h"
#include "udp_transport/routing/group_keeper.h"

namespace sft::udp {

/// Readers with equal masks and limits. They share an encoding of each sample, and have one lane for each
/// destination. A late reader is a separate audience, so that its samples can begin with the retained
/// samples.
struct Audience {
  detail::ProjectionPlan plan;
  /// The gate that selects the samples for the audience by rate or conditions; null: every sample is for the
  /// audience.
  std::shared_ptr<const core::Gate> gate;
  core::EndpointId late_reader = 0;  ///< the late reader of the audience; 0: it has none
  bool fallback = false;  ///< true if the audience also gets samples that are only for fallback routes
  std::shared_ptr<const WireMask> wire;
  std::vector<std::shared_ptr<Lane>> lanes;
  /// The channel for each lane; null if no reader of that lane is served reliably.
  std::vector<std::shared_ptr<Channel>> channels{};
  /// If not null, this group sends to the whole audience. Then lanes send only to members that do not
  /// receive the group's datagrams. A member has the same index as its lane.
  std::shared_ptr<MulticastGroup> multicast{};
  std::shared_ptr<core::DeliveryTally> tally = std::make_shared<core::DeliveryTally>();
  /// True if small samples that are published together may share datagrams. In that case, all samples with
  /// one mask are sent before the first sample with another mask. So each destination must get only one
  /// mask. Otherwise a reader that changes its mask would miss some samples.
  bool packs = false;
  /// True if readers of the audience may have different requests. Then `wire` is a mask that contains the
  /// masks of all requests.
  bool merged = false;

  /// Returns true if the sample that is being published is for the audience. Must be called by the
  /// publisher's thread.
  bool wants_sample() const { return gate == nullptr || gate->passes(); }
};

/// The audiences of a writer. A table is immutable: each change of routes makes a new table.
struct RouteTable {
  std::vector<Audience> audiences;  ///< audiences of fallback routes come last
  core::DeliveryBook::Page page;    ///< assigns the tallies of deliveries to readers
  /// The lane to each reader, except fallback lanes.
  std::map<core::EndpointId, std::shared_ptr<Lane>> lanes_of;

  std::size_t usual = 0;               ///< number of audiences that are not fallback audiences
  std::shared_ptr<BodySizes> sizes{};  ///< measures the sizes of samples; null: no sizes have to be measured

  /// Returns the audiences that the sample may be for.
  std::span<const Audience> reached(core::Reach reach) const {
    return std::span(audiences).first(reach == core::Reach::usual_routes ? usual : audiences.size());
  }
  /// Returns the audience of this late reader; null if there is none.
  const Audience* of_late_reader(core::EndpointId reader) const;
};

/// The variants of a writer's samples: one for each present or former request of its readers. Each variant
/// has its number and its lanes, so that its samples stay in order while routes change. A late reader has
/// one lane, whatever it requests. A number is reused only after all other numbers have been used.
class VariantDirectory {
 public:
  struct Variant {
    core::Wanted wanted;
    core::EndpointId late_reader;  ///< the late reader of the variant; 0: it has none
    std::shared_ptr<const WireMask> wire;
    std::vector<std::shared_ptr<Lane>> lanes;
    std::uint64_t last_use;

    bool is_for(const core::Wanted& that, std::uint64_t hash, core::EndpointId reader) const {
      return wire->mask == hash && wanted == that && late_reader == reader;
    }
  };

  /// `channels` must outlive the directory; null: no reader is served reliably.
  VariantDirectory(std::size_t queue_depth, std::shared_ptr<WriterTally> tally,
                   ChannelDirectory* channels = nullptr);

  /// Returns the variant for readers with that request, and makes it if necessary. The reference is valid
  /// until the next call.
  Variant& find(const core::Wanted& wanted, core::EndpointId late_reader = 0);
  /// Returns the lane of the variant to that destination, and makes it if necessary.
  std::shared_ptr<Lane> lane(Variant& variant, const std::shared_ptr<Destination>& to,
                             const std::shared_ptr<Channel>& channel = {});
  /// Returns the channel to `readers`, which are the reliable readers at that destination; null if the
  /// directory has no channels.
  std::shared_ptr<Channel> channel(const std::shared_ptr<Destination>& to,
                                   const std::set<core::EndpointId>& readers) {
    return channels_ == nullptr ? nullptr : channels_->find(to, readers);
  }
  void keep_channels_to(const ReliableReaders& readers) {
    if (channels_ != nullptr) channels_->keep_to(readers);
  }

  /// Closes and removes all lanes to destinations that are not in `served`. Lanes of late readers that are
  /// not in `late_readers` are removed, too, but their queued samples are still sent.
  void keep_lanes_to(const std::set<const Destination*>& served,
                     const std::set<core::EndpointId>& late_readers);

  /// Returns true if the sending thread should check its lanes, because lanes or channels were closed or a
  /// destination has moved since the last call. Other changes of requests do not concern the sending thread.
  bool concern_sender() {
    const bool closed_channels = channels_ != nullptr && channels_->take_closed();
    const bool some_moved = std::exchange(known_moves_, moves_) != moves_;
    return std::exchange(closed_, false) || closed_channels || some_moved;
  }

  /// Returns true if the retained samples for that late reader have been sent, and no sample waits in its
  /// lane.
  bool late_lane_idle(core::EndpointId reader) const;

  /// Removes the variants that have been unused for the longest time, and keeps a limited number of unused
  /// ones. Called between two rounds of find(), one for each change of routes.
  void next_round();

 private:
  std::uint16_t unused_number();
  std::shared_ptr<Lane> late_lane(core::EndpointId reader, const std::shared_ptr<Destination>& to,
                                  const std::shared_ptr<Channel>& channel);
  void close(Lane& lane);

  static constexpr std::size_t remembered_max = 64;
  const std::size_t queue_depth_;
  const std::shared_ptr<WriterTally> tally_;
  ChannelDirectory* const channels_;
  std::vector<Variant> variants_;
  std::map<core::EndpointId, std::shared_ptr<Lane>> late_lanes_;
  std::uint16_t next_number_ = 0;
  std::uint64_t round_ = 0;
  bool closed_ = false;
  std::uint64_t moves_ = 0;        ///< sum of the moves of the destinations of all lanes of this round
  std::uint64_t known_moves_ = 0;  ///< value of `moves_` at the last call of concern_sender()
};

/// Returns the table of a writer of `type`, which must outlive the table. Routes that do not lead to a UDP
/// address are omitted. Lanes to destinations without a route are closed. If `keeper` is null, there are no
/// multicast groups.
std::shared_ptr<const RouteTable> make_route_table(const TypeSupport& type,
                                                   std::span<const core::Route> routes,
                                                   VariantDirectory& variants,
                                                   DestinationDirectory& destinations,
                                                   GroupKeeper* keeper = nullptr);

}  // namespace sft::udp
