#include "core/subscribe/channel_numbers.h"

#include <algorithm>
#include <utility>

#include "sft/detail/layout.h"

namespace sft::core {

namespace {

using detail::LayoutRole;

void insert(FieldMask& mask, const detail::Layout::Field& field) {
  const std::size_t leaves = field ? leaf_count(*field.member) : 0;
  for (std::size_t i = 0; i < leaves; ++i) mask.insert(field.leaf + i);
}

}  // namespace

std::vector<ChannelNumbers::Cloud> ChannelNumbers::clouds_of(const StructType& type) {
  std::vector<Cloud> clouds;
  for (const detail::Layout& layout : detail::layouts_of(type)) {
    if (!layout.has_channels()) continue;
    for (const detail::Layout::Field& data : layout.data) {
      Cloud cloud{.data = data.leaf, .fields = FieldMask(type.leaves), .changed = FieldMask(type.leaves)};
      insert(cloud.changed, data);
      for (const LayoutRole role : {LayoutRole::channels, LayoutRole::cell_bytes, LayoutRole::row_bytes})
        insert(cloud.changed, layout[role]);
      cloud.fields = cloud.changed;
      for (const LayoutRole role : {LayoutRole::rows, LayoutRole::columns, LayoutRole::byte_order})
        insert(cloud.fields, layout[role]);
      clouds.push_back(std::move(cloud));
    }
  }
  return clouds;
}

ChannelNumbers::ChannelNumbers(std::size_t leaves, std::vector<Cloud> clouds)
    : leaves_(leaves),
      clouds_(std::move(clouds)),
      channels_(clouds_.empty() ? nullptr : std::make_unique<Channel[]>(most)) {}

std::optional<std::size_t> ChannelNumbers::find(std::size_t leaf, std::string_view name) const {
  const std::size_t count = count_.load(std::memory_order_acquire);
  for (std::size_t i = 0; i < count; ++i) {
    if (channels_[i].cloud->data == leaf && channels_[i].name == name) return leaves_ + i;
  }
  return {};
}

bool ChannelNumbers::can_be_named(std::size_t leaf, std::string_view name) const {
  return Selection::make(FieldMask(leaves_),
                         {{.leaf = static_cast<std::uint32_t>(leaf), .channels = {std::string(name)}}}, {})
      .has_value();
}

std::optional<std::size_t> ChannelNumbers::number_of(std::size_t leaf, std::string_view name) {
  if (const auto known = find(leaf, name)) return known;
  if (count_.load(std::memory_order_relaxed) == most) return {};
  const auto cloud = std::ranges::find(clouds_, leaf, &Cloud::data);
  if (cloud == clouds_.end() || !can_be_named(leaf, name)) return {};
  const Lock lock(mutex_);
  if (const auto known = find(leaf, name)) return known;  // another thread has added the channel
  const std::size_t next = count_.load(std::memory_order_relaxed);
  if (next == most) return {};
  channels_[next] = {&*cloud, std::string(name)};
  count_.store(next + 1, std::memory_order_release);
  return leaves_ + next;
}

std::vector<std::string> ChannelNumbers::channels_of(const Cloud& cloud, const FieldMask& numbers) const {
  std::vector<std::string> names;
  const std::size_t count = count_.load(std::memory_order_acquire);
  for (std::size_t i = 0; i < count; ++i) {
    if (channels_[i].cloud == &cloud && numbers.contains(leaves_ + i)) names.push_back(channels_[i].name);
  }
  return names;
}

Selection ChannelNumbers::selection(const FieldMask& numbers) const {
  FieldMask fields = FieldMask::from_words(leaves_, numbers.to_words());
  std::vector<Selection::Part> parts;
  for (const Cloud& cloud : clouds_) {
    std::vector<std::string> channels = channels_of(cloud, numbers);
    if (channels.empty()) continue;
    if (fields.intersects(cloud.changed)) {
      fields |= cloud.fields;
    } else {
      parts.push_back({.leaf = static_cast<std::uint32_t>(cloud.data), .channels = std::move(channels)});
      fields.insert(cloud.data);
    }
  }
  if (Result<Selection> asked = Selection::make(fields, std::move(parts), {})) return *std::move(asked);
  // The selection has too many parts or names, so it asks for whole points.
  for (const Cloud& cloud : clouds_) {
    if (fields.contains(cloud.data)) fields |= cloud.fields;
  }
  return fields;
}

std::optional<detail::ChannelsSent> ChannelNumbers::sent_for(const Selection& selection) const {
  FieldMask changed(leaves_);
  for (const Cloud& cloud : clouds_) {
    if (selection.part(cloud.data) != nullptr) changed |= cloud.changed;
  }
  if (changed.empty()) return {};
  return detail::ChannelsSent{selection, std::move(changed)};
}

}  // namespace sft::core
