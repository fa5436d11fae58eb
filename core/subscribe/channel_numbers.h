// The channels of clouds that a program has read. The numbers of channels follow those of the leaves, so that
// a channel is recorded like a leaf. A channel gets its number when it is read for the first time, and keeps
// it.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/sync/mutex.h"
#include "sft/detail/access_log.h"
#include "sft/detail/type_table.h"
#include "sft/selection.h"

namespace sft::core {

class ChannelNumbers {
 public:
  /// The most channels, for all clouds of a type together.
  static constexpr std::size_t most = Selection::channels_max;

  /// A cloud for which parts with channels can be requested.
  struct Cloud {
    std::size_t data = 0;  ///< the leaf with the points
    FieldMask fields;      ///< `data`, and all fields that describe the layout of its points
    /// The fields in `fields` whose values differ if only some channels are sent. A program that reads one of
    /// them needs whole points.
    FieldMask changed;
  };
  /// Returns the clouds of a type, except for those in arrays and sequences.
  static std::vector<Cloud> clouds_of(const StructType& type);

  ChannelNumbers(std::size_t leaves, std::vector<Cloud> clouds);

  /// Returns the count of all numbers, including those of the leaves.
  std::size_t numbers() const { return leaves_ + (clouds_.empty() ? 0 : most); }
  /// Returns true if the type has clouds.
  bool has_clouds() const { return !clouds_.empty(); }

  /// Returns the number of a channel. Returns nothing if the leaf has no points, if a request cannot name the
  /// channel, or if there are too many channels. Allocates memory only for a channel that was never read
  /// before. Any thread.
  std::optional<std::size_t> number_of(std::size_t leaf, std::string_view name);
  /// Returns the fields that are read together with the channel of that number. Any thread.
  const FieldMask& fields_of(std::size_t number) const { return channels_[number - leaves_].cloud->fields; }

  /// Returns the selection of the whole fields and the channels with these numbers. If points are whole, all
  /// fields that describe their layout are whole, too; a part includes them anyway. Any thread.
  Selection selection(const FieldMask& numbers) const;
  /// Describes the difference between samples of that selection and the published messages. Returns nothing
  /// if they do not differ. Any thread.
  std::optional<detail::ChannelsSent> sent_for(const Selection& selection) const;

 private:
  struct Channel {
    const Cloud* cloud = nullptr;
    std::string name;
  };

  std::optional<std::size_t> find(std::size_t leaf, std::string_view name) const;
  bool can_be_named(std::size_t leaf, std::string_view name) const;
  std::vector<std::string> channels_of(const Cloud& cloud, const FieldMask& numbers) const;

  const std::size_t leaves_;
  const std::vector<Cloud> clouds_;
  Mutex mutex_;  // held while a channel is added
  /// Channels with a number below count_ never change.
  const std::unique_ptr<Channel[]> channels_;
  std::atomic<std::size_t> count_{0};
};

}  // namespace sft::core
