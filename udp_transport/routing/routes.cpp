#include "udp_transport/routing/routes.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {

/// Returns the words of the mask that are sent on the wire. They are empty if the hash alone identifies the
/// mask. They are also empty if the selection has parts or conditions, since readers then know the hash of
/// their own request only.
std::vector<std::uint64_t> words_to_send(const Selection& selection) {
  std::vector<std::uint64_t> words;
  const FieldMask& mask = selection.mask();
  if (!selection.is_mask() || mask.words() == 1 || mask.words() > WireMask::words_max) return words;
  for (std::size_t i = 0; i < mask.words(); ++i) words.push_back(mask.word(i));
  return words;
}

std::shared_ptr<const WireMask> make_wire_mask(const Selection& selection, std::uint16_t number) {
  return std::make_shared<WireMask>(WireMask{number, selection.hash(), words_to_send(selection)});
}

/// Adds the readers to the table's page of delivery counts. For fallback routes, samples that a gate
/// withholds are not counted here, because the other transport that serves these readers counts them.
void write_page(const RouteBundle& bundle, const Audience& audience, RouteTable& table) {
  for (const auto& [reader, destination] : bundle.readers) {
    const auto leads_there = [to = destination](const auto& lane) { return &lane->destination() == to; };
    const auto lane = std::find_if(audience.lanes.begin(), audience.lanes.end(), leads_there);
    if (!audience.fallback) table.lanes_of[reader] = *lane;
    table.page.push_back({reader,
                          {.tally = audience.tally,
                           .losses = (*lane)->losses(),
                           .gate = audience.fallback ? nullptr : audience.gate,
                           .diverted = audience.fallback}});
  }
}

std::vector<MulticastGroup::Member> members_of(const Audience& audience) {
  std::vector<MulticastGroup::Member> members;
  for (std::size_t i = 0; i < audience.lanes.size(); ++i)
    members.push_back({audience.lanes[i], audience.channels[i]});
  return members;
}

ReliableReaders reliable_readers(const std::vector<RouteBundle>& bundles) {
  ReliableReaders all;
  for (const RouteBundle& bundle : bundles) {
    for (const auto& [destination, readers] : bundle.reliable)
      all[destination].insert(readers.begin(), readers.end());
  }
  return all;
}

/// Returns true if a lane of another audience sends the same samples to the same destination. That happens
/// because readers in one process share a socket.
bool is_reached_anyway(const RouteTable& table, const Audience& fallback, std::size_t lane) {
  return std::any_of(table.audiences.begin(), table.audiences.end(), [&](const Audience& audience) {
    if (&audience == &fallback || audience.wire != fallback.wire) return false;
    const auto same = std::find(audience.lanes.begin(), audience.lanes.end(), fallback.lanes[lane]);
    return same != audience.lanes.end() &&
           (fallback.channels[lane] == nullptr ||
            audience.channels[same - audience.lanes.begin()] == fallback.channels[lane]);
  });
}

void leave_out_the_reached(const RouteTable& table, Audience& fallback) {
  for (std::size_t lane = fallback.lanes.size(); lane-- > 0;) {
    if (!is_reached_anyway(table, fallback, lane)) continue;
    fallback.lanes.erase(fallback.lanes.begin() + static_cast<std::ptrdiff_t>(lane));
    fallback.channels.erase(fallback.channels.begin() + static_cast<std::ptrdiff_t>(lane));
  }
}

}  // namespace

const Audience* RouteTable::of_late_reader(core::EndpointId reader) const {
  const auto found = std::find_if(audiences.begin(), audiences.end(),
                                  [&](const Audience& a) { return a.late_reader == reader; });
  return found == audiences.end() ? nullptr : &*found;
}

VariantDirectory::VariantDirectory(std::size_t queue_depth, std::shared_ptr<WriterTally> tally,
                                   ChannelDirectory* channels)
    : queue_depth_(queue_depth), tally_(std::move(tally)), channels_(channels) {}

VariantDirectory::Variant& VariantDirectory::find(const core::Wanted& wanted, core::EndpointId late_reader) {
  const std::uint64_t hash = wanted.selection.hash();
  auto known = std::ranges::find_if(
      variants_, [&](const Variant& variant) { return variant.is_for(wanted, hash, late_reader); });
  if (known == variants_.end()) {
    variants_.push_back({wanted, late_reader, make_wire_mask(wanted.selection, unused_number()), {}, round_});
    known = variants_.end() - 1;
  }
  known->last_use = round_;
  return *known;
}

std::shared_ptr<Lane> VariantDirectory::lane(Variant& variant, const std::shared_ptr<Destination>& to,
                                             const std::shared_ptr<Channel>& channel) {
  moves_ += to->moves();
  if (variant.late_reader != 0) return late_lane(variant.late_reader, to, channel);
  for (const std::shared_ptr<Lane>& lane : variant.lanes) {
    if (&lane->destination() == to.get()) return lane;
  }
  return variant.lanes.emplace_back(std::make_shared<Lane>(to, queue_depth_, tally_));
}

/// Returns the lane of a late reader. A new lane is held until begin() adds the retained samples. If the
/// reader has moved to another destination, it gets a new lane, because jobs in the old lane do not reach it
/// any more.
std::shared_ptr<Lane> VariantDirectory::late_lane(core::EndpointId reader,
                                                  const std::shared_ptr<Destination>& to,
                                                  const std::shared_ptr<Channel>& channel) {
  std::shared_ptr<Lane>& lane = late_lanes_[reader];
  if (lane != nullptr && &lane->destination() == to.get() && lane->channel() == channel.get()) return lane;
  if (lane != nullptr) close(*lane);
  lane = std::make_shared<Lane>(to, queue_depth_, tally_, Lane::Start::held, channel);
  return lane;
}

void VariantDirectory::close(Lane& lane) {
  lane.close();
  closed_ = true;
}

void VariantDirectory::keep_lanes_to(const std::set<const Destination*>& served,
                                     const std::set<core::EndpointId>& late_readers) {
  const auto close_if_unserved = [&](const std::shared_ptr<Lane>& lane) {
    if (served.contains(&lane->destination())) return false;
    close(*lane);
    return true;
  };
  for (Variant& variant : variants_) std::erase_if(variant.lanes, close_if_unserved);
  std::erase_if(late_lanes_, [&](const auto& item) {
    return close_if_unserved(item.second) || !late_readers.contains(item.first);
  });
}

bool VariantDirectory::late_lane_idle(core::EndpointId reader) const {
  const auto lane = late_lanes_.find(reader);
  return lane == late_lanes_.end() || lane->second->history_has_departed();
}

std::uint16_t VariantDirectory::unused_number() {
  const auto used = [this](std::uint16_t number) {
    return std::any_of(variants_.begin(), variants_.end(),
                       [&](const Variant& v) { return v.wire->variant == number; });
  };
  while (used(next_number_)) ++next_number_;
  return next_number_++;
}

void VariantDirectory::next_round() {
  ++round_;
  moves_ = 0;
  while (variants_.size() > remembered_max) {
    const auto oldest =
        std::min_element(variants_.begin(), variants_.end(),
                         [](const Variant& a, const Variant& b) { return a.last_use < b.last_use; });
    // Even the oldest of the remaining variants was in use until now.
    if (oldest->last_use + 1 >= round_) return;
    std::swap(*oldest, variants_.back());
    variants_.pop_back();
  }
}

/// Sets Audience::packs. An audience with a gate, with a late reader or with parts of fields never gets
/// packs. The others get packs if each of their destinations gets only one mask.
static void allow_packs(RouteTable& table) {
  const auto may_pack = [](const Audience& audience) {
    return audience.gate == nullptr && audience.late_reader == 0 && !audience.plan.has_parts();
  };
  std::map<const Destination*, int> masks;
  for (const Audience& audience : table.audiences) {
    for (const auto& lane : audience.lanes) masks[&lane->destination()] += may_pack(audience) ? 1 : 0;
  }
  for (Audience& audience : table.audiences) {
    audience.packs = may_pack(audience) && std::ranges::all_of(audience.lanes, [&](const auto& lane) {
                       return masks[&lane->destination()] == 1;
                     });
  }
}

std::shared_ptr<const RouteTable> make_route_table(const TypeSupport& type,
                                                   std::span<const core::Route> routes,
                                                   VariantDirectory& variants,
                                                   DestinationDirectory& destinations, GroupKeeper* keeper) {
  auto table = std::make_shared<RouteTable>();
  std::set<const Destination*> served;
  std::set<core::EndpointId> late_readers;
  variants.next_round();
  std::vector<RouteBundle> bundles = bundle_routes(routes, destinations);
  const ReliableReaders reliable = reliable_readers(bundles);
  const auto now = std::chrono::steady_clock::now();
  if (keeper != nullptr) keeper->merge(bundles, now);
  for (RouteBundle& bundle : bundles) {
    VariantDirectory::Variant& variant = variants.find(bundle.wanted, bundle.late_reader);
    Audience& audience =
        table->audiences.emplace_back(Audience{detail::ProjectionPlan(type, bundle.wanted.selection),
                                               bundle.gate,
                                               bundle.late_reader,
                                               bundle.fallback,
                                               variant.wire,
                                               {}});
    audience.merged = bundle.merged && !bundle.is_for_some_samples() && bundle.wanted.selection.is_mask();
    for (const std::shared_ptr<Destination>& to : bundle.destinations) {
      const bool is_reliable = bundle.reliable.contains(to.get());
      audience.channels.push_back(is_reliable ? variants.channel(to, reliable.at(to.get())) : nullptr);
      audience.lanes.push_back(variants.lane(variant, to, audience.channels.back()));
      audience.lanes.back()->end().set_shared(bundle.merged && !bundle.multicast);
      served.insert(to.get());
    }
    if (bundle.multicast) audience.multicast = keeper->find(*bundle.multicast, members_of(audience));
    if (bundle.late_reader != 0) late_readers.insert(bundle.late_reader);
    write_page(bundle, audience, *table);
    if (bundle.fallback) {
      leave_out_the_reached(*table, audience);
    } else {
      table->usual = table->audiences.size();
    }
  }
  allow_packs(*table);
  variants.keep_lanes_to(served, late_readers);
  variants.keep_channels_to(reliable);
  if (keeper != nullptr) {
    keeper->merged(now);
    table->sizes = keeper->sizes();
  }
  return table;
}

}  // namespace sft::udp
