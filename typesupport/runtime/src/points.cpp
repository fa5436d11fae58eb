#include "sft/points.h"

#include <optional>
#include <string>

#include "sft/detail/parts_in_place.h"
#include "sft/detail/text.h"
#include "sft/dynamic_view.h"
#include "sft/selection.h"

namespace sft::detail {

namespace {

/// A type of sensor_msgs/PointField, where the types are numbered from 1.
struct PointType {
  std::uint8_t bytes;
  std::string_view name;
};
constexpr std::array<PointType, 9> point_types{{{0, ""},
                                                {1, "int8"},
                                                {1, "uint8"},
                                                {2, "int16"},
                                                {2, "uint16"},
                                                {4, "int32"},
                                                {4, "uint32"},
                                                {4, "float"},
                                                {8, "double"}}};

/// The header of a cloud.
struct Header {
  std::uint32_t rows = 0;
  std::uint32_t columns = 0;
  std::uint32_t point_step = 0;
  std::uint32_t row_step = 0;
  bool is_big_endian = false;
};

/// A channel in the description of the cloud.
struct Channel {
  std::string_view name;
  std::uint32_t offset;
  std::uint8_t type;
  std::uint32_t count;

  /// Returns true if the channel has one of the eight types, has elements, and lies within the point.
  bool is_there(std::uint32_t point_step) const { return end() > offset && end() <= point_step; }
  /// Returns the offset of the first byte after the channel; `offset` if the channel has no bytes.
  std::uint64_t end() const {
    const std::uint64_t bytes = type < point_types.size() ? point_types[type].bytes : 0;
    return offset + bytes * count;
  }
};

/// Reads a number, aligned to its size, exactly once. A compiler must not read it again.
template <class T>
bool read_once(const SampleState& s, std::uint64_t offset, T& value) {
  const std::uint32_t at = offset == no_offset ? no_offset : checked_block(s, offset, 1, sizeof(T));
  if (at == no_offset) return false;
  value = __atomic_load_n(reinterpret_cast<const T*>(s.body + at), __ATOMIC_RELAXED);
  return true;
}

/// Reads one channel, and advances the offset to the next channel.
std::optional<Channel> next_channel(const SampleState& s, std::uint64_t& offset) {
  const Extent name = checked_length(s, offset);
  if (!name || checked_block(s, name.first, name.count, 1) == no_offset) return {};
  const std::uint64_t behind_name = align_up(std::uint64_t{name.first} + name.count, 4);
  offset = behind_name + 12;
  Channel channel{
      {reinterpret_cast<const char*>(s.body + name.first), name.count == 0 ? 0 : name.count - 1}, 0, 0, 0};
  if (!read_once(s, behind_name, channel.offset) || !read_once(s, behind_name + 4, channel.type) ||
      !read_once(s, behind_name + 8, channel.count))
    return {};
  return channel;
}

tl::unexpected<Error> malformed(const SampleState& s) {
  s.flag_malformed();
  return fail(Errc::malformed, "the cloud is not within the bytes of the sample");
}

/// Returns the names of the channels for error messages. Names that must not be sent to a terminal are left
/// out, and the length is limited.
std::string names_of_channels(const SampleState& s, std::uint64_t fields, std::uint32_t point_step) {
  constexpr std::size_t longest_name = 64;
  std::string names;
  const Extent all = checked_length(s, fields);
  std::uint64_t offset = all.first;
  std::size_t named = 0;
  for (std::uint32_t i = 0; i < all.count; ++i) {
    const std::optional<Channel> channel = next_channel(s, offset);
    if (!channel) break;
    if (!channel->is_there(point_step)) continue;
    if (named++ == Selection::channels_max) return names + ", ...";
    const std::string name(channel->name.substr(0, longest_name + 1));
    names += (names.empty() ? "" : ", ") + (name.size() <= longest_name && is_printable(name) ? name : "...");
  }
  return names.empty() ? "none" : names;
}

/// Returns an error text that says why the first channel of that name, which the cloud has, cannot be read.
std::string fault_of_channel(const SampleState& s, std::uint64_t fields, std::uint32_t point_step,
                             const std::string& name) {
  const Extent all = checked_length(s, fields);
  std::uint64_t offset = all.first;
  for (std::uint32_t i = 0; i < all.count; ++i) {
    const std::optional<Channel> channel = next_channel(s, offset);
    if (!channel) break;
    if (channel->name != name) continue;
    if (channel->count == 0) return "channel '" + name + "' has a count of 0";
    if (channel->end() == channel->offset)
      return "channel '" + name + "' has the unknown type " + std::to_string(channel->type);
    return "channel '" + name + "' ends " + std::to_string(channel->end() - point_step) +
           " bytes behind the end of its point";
  }
  return "channel '" + name + "' has changed";  // another program has written to the sample meanwhile
}

/// Finds the channels of the cloud. Returns false if the bytes of the sample are malformed.
bool find_channels(const SampleState& s, std::uint64_t fields, std::uint32_t point_step,
                   std::span<WantedChannel> wanted) {
  const Extent all = checked_length(s, fields);
  if (!all) return false;
  std::uint64_t offset = all.first;
  std::size_t left = wanted.size();
  for (std::uint32_t i = 0; i < all.count && left > 0; ++i) {
    const std::optional<Channel> channel = next_channel(s, offset);
    if (!channel) return false;
    for (WantedChannel& one : wanted) {
      if (one.is_found || one.name != channel->name) continue;
      one.is_found = true;
      --left;
      if (!channel->is_there(point_step)) continue;
      one.offset = channel->offset;
      one.found_type = channel->type;
      if (one.type != 0) continue;
      one.type = channel->type;
      one.count = channel->count;
    }
  }
  return true;
}

/// Returns the points, or an error if not all points are within the data. Drivers that organise a cloud
/// often leave row_step unchanged. So row_step is ignored if the data has exactly the bytes of all points:
/// rows then follow each other.
Result<CellGrid> grid_of(const Header& header, std::span<const std::byte> data) {
  CellGrid grid{.first = data.data(),
                .row_step = header.row_step,
                .column_step = header.point_step,
                .rows = header.rows,
                .columns = header.columns,
                .is_swapped = header.is_big_endian};
  const std::uint64_t row_end = std::uint64_t{grid.columns} * grid.column_step;
  const bool is_joined = grid.rows > 0 && data.size() % grid.rows == 0 && data.size() / grid.rows == row_end;
  if (grid.rows <= 1 || row_end == 0 || is_joined) grid.row_step = std::max<std::uint64_t>(row_end, 1);
  if (grid.rows == 0 || grid.columns == 0) return grid;
  const bool has_room = grid.column_step > 0 && row_end <= data.size() &&
                        (grid.rows == 1 || (row_end <= grid.row_step &&
                                            (grid.rows - 1) * grid.row_step <= data.size() - row_end));
  if (has_room) return grid;
  const auto text = [](std::uint64_t number) { return std::to_string(number); };
  return fail(Errc::malformed, "the cloud contradicts itself: " + text(header.rows) + " x " +
                                   text(header.columns) + " points, point_step " + text(header.point_step) +
                                   " and row_step " + text(header.row_step) + " do not fit the " +
                                   text(data.size()) + " bytes of data");
}

/// Reads the header. Returns false if the bytes of the sample are malformed.
bool read_header(const CloudPlace& cloud, Header& header) {
  const auto& [height, width, fields, is_big_endian, point_step, row_step, data] = cloud.offsets;
  std::uint8_t byte_order = 0;
  if (!read_once(*cloud.sample, height, header.rows) || !read_once(*cloud.sample, width, header.columns) ||
      !read_once(*cloud.sample, is_big_endian, byte_order) ||
      !read_once(*cloud.sample, point_step, header.point_step) ||
      !read_once(*cloud.sample, row_step, header.row_step))
    return false;
  header.is_big_endian = byte_order != 0;
  return true;
}

/// Changes the offset of a channel from its offset in a packed point to its offset in the larger cloud.
/// Returns false if the channel is not within the cells of the part: its data was not cut as points of this
/// cloud.
bool place_channel(const Cut& cut, WantedChannel& one) {
  const std::uint64_t bytes = std::uint64_t{point_types[one.type].bytes} * one.count;
  // Points are whole if no channels were requested.
  if (cut.channels().empty()) return one.offset + bytes <= cut.cell_bytes();
  std::uint32_t packed = 0;
  for (const Cut::Channel& channel : cut.channels()) {
    if (packed == one.offset && channel.bytes >= bytes) {
      one.offset = channel.offset;
      return true;
    }
    packed += channel.bytes;
  }
  return false;
}

/// Returns true if two channels of the cloud have bytes in common, or if it has more channels than a
/// selection can name. A part with some of these channels could be larger than the points.
bool channels_overlap(const SampleState& s, std::uint64_t fields, std::uint32_t point_step) {
  std::array<Channel, Selection::channels_max> seen;
  std::size_t count = 0;
  const Extent all = checked_length(s, fields);
  std::uint64_t offset = all.first;
  for (std::uint32_t i = 0; i < all.count; ++i) {
    const std::optional<Channel> channel = next_channel(s, offset);
    if (!channel) break;
    if (!channel->is_there(point_step)) continue;
    const auto overlaps = [&](const Channel& other) {
      return channel->offset < other.end() && other.offset < channel->end();
    };
    if (count == seen.size() || std::any_of(seen.begin(), seen.begin() + count, overlaps)) return true;
    seen[count++] = *channel;
  }
  return false;
}

/// Returns the points of a part that stays in a larger cloud, and sets the offsets of the channels there.
CellGrid grid_in_place(const Header& header, const PartInPlace& place, std::span<WantedChannel> wanted) {
  const Cut& cut = *place.cut;
  for (WantedChannel& one : wanted) {
    if (!place_channel(cut, one)) return {};
  }
  CellGrid grid = CellGrid::of(*place.source, cut);
  grid.is_swapped = header.is_big_endian;
  return grid;
}

}  // namespace

Result<CellGrid> find_points(const CloudPlace& cloud, std::span<WantedChannel> wanted) {
  const SampleState& s = *cloud.sample;
  const std::uint64_t fields = cloud.offsets[2];
  const Extent data = checked_sequence(s, cloud.offsets[6], 1);
  Header header;
  if (!data || !read_header(cloud, header) || !find_channels(s, fields, header.point_step, wanted))
    return malformed(s);
  // Parts of clouds with overlapping channels might be empty. So whole points are recorded for them.
  if (s.log != nullptr && s.log->is_as_published(cloud.data_leaf, 1) &&
      channels_overlap(s, fields, header.point_step))
    s.log->touch(cloud.data_leaf, true);
  for (const WantedChannel& one : wanted) {
    if (one.found_type == one.type && one.found_type != 0) continue;
    const std::string name(one.name);
    if (one.found_type == 0 && one.is_found)
      return fail(Errc::unknown_field, fault_of_channel(s, fields, header.point_step, name));
    if (one.found_type == 0) {
      return fail(Errc::unknown_field, "the cloud has no channel '" + name + "'; it has " +
                                           names_of_channels(s, fields, header.point_step));
    }
    return fail(Errc::type_mismatch, "channel '" + name + "' is " +
                                         std::string(point_types[one.found_type].name) + ", not " +
                                         std::string(point_types[one.type].name));
  }
  if (s.parts != nullptr) {
    if (const auto place = s.parts->find(cloud.data_leaf)) return grid_in_place(header, *place, wanted);
  }
  return grid_of(header, {s.body + data.first, data.count});
}

namespace {

constexpr std::size_t data_field = cloud_fields.size() - 1;

tl::unexpected<Error> not_sent(const std::string& what) {
  return fail(Errc::unavailable, what + " was not sent in this sample");
}

tl::unexpected<Error> field_not_sent(std::size_t field) {
  return not_sent("'" + std::string(cloud_fields[field]) + "'");
}

/// The result of noting the channels that are read.
struct NotedChannels {
  bool one_by_one = false;                 ///< true if channels are noted one by one
  const WantedChannel* missing = nullptr;  ///< the first channel that was not sent
};

NotedChannels note_channels(const SampleState& s, const LeafRange& data,
                            std::span<const WantedChannel> wanted) {
  NotedChannels noted{.one_by_one = s.log != nullptr};
  const bool has_data = s.mask->all_of(data.first, data.count);
  for (const WantedChannel& one : wanted) {
    if (!noted.one_by_one) break;
    const std::optional<bool> was_sent = s.log->touch_channel(data.first, one.name, has_data);
    noted.one_by_one = was_sent.has_value();
    if (noted.one_by_one && !*was_sent && noted.missing == nullptr) noted.missing = &one;
  }
  return noted;
}

}  // namespace

// All channels are noted before an error for a missing channel is returned, so that the subscriber requests
// all channels at once.
Result<void> note_points(const SampleState& s, const CloudLeaves& leaves,
                         std::span<const WantedChannel> wanted) {
  const NotedChannels noted = note_channels(s, leaves[data_field], wanted);
  std::optional<std::size_t> missing;
  for (std::size_t field = 0; field < leaves.size(); ++field) {
    const bool was_sent = noted.one_by_one ? s.mask->all_of(leaves[field].first, leaves[field].count)
                                           : note_leaves(s, leaves[field].first, leaves[field].count);
    if (!was_sent && !missing) missing = field;
  }
  if (missing) return field_not_sent(*missing);
  if (noted.one_by_one && noted.missing != nullptr)
    return not_sent("channel '" + std::string(noted.missing->name) + "'");
  return {};
}

Result<CloudPlace> cloud_place_of(const DynamicView& view, std::span<const WantedChannel> wanted) {
  if (view.error() != nullptr) return tl::unexpected(*view.error());
  const std::optional<CloudMembers> members =
      view.is_struct() ? cloud_members_of(*view.type()) : std::nullopt;
  if (!members) return tl::unexpected(view.not_readable("a cloud"));
  CloudPlace cloud{view.state_, {}};
  CloudLeaves leaves;
  std::optional<std::size_t> undeclared;
  for (std::size_t field = 0; field < members->size(); ++field) {
    const Member& member = view.type()->members[(*members)[field]];
    const DynamicView::Place place = view.place_of((*members)[field]);
    leaves[field] = {place.leaf, leaf_count(member)};
    if (field == data_field) cloud.data_leaf = place.leaf;
    if (!undeclared && !view.has_all_of(place.leaf, leaf_count(member))) undeclared = field;
    cloud.offsets[field] = place.slot == DynamicView::no_slot
                               ? place.offset
                               : __atomic_load_n(cloud.sample->index + place.slot, __ATOMIC_RELAXED);
  }
  if (const Result<void> sent = note_points(*cloud.sample, leaves, wanted); !sent)
    return tl::unexpected(sent.error());
  if (undeclared) return field_not_sent(*undeclared);
  return cloud;
}

}  // namespace sft::detail
