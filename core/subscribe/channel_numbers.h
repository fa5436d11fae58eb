// The channels of clouds that a program was seen to read. Each has a number behind those of the leaves, so
// that it is recorded like a leaf. A channel gets its number when it is read for the first time, and keeps
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
  /// The channels of all clouds in a type.
  static constexpr std::size_t most = Selection::channels_max;

  /// A cloud of which parts with channels can be asked for.
  struct Cloud {
    std::size_t data = 0;  ///< the leaf with the points
    FieldMask fields;      ///< this one, and all that say how the points lie in it
    /// The fields among them that a part with some channels changes. A program that reads one of these needs
    /// whole points.
    FieldMask changed;
  };
  /// The clouds of a type, except of those in arrays and sequences.
  static std::vector<Cloud> clouds_of(const StructType& type);

  ChannelNumbers(std::size_t leaves, std::vector<Cloud> clouds);

  /// So many numbers there are, those of the leaves included.
  std::size_t numbers() const { return leaves_ + (clouds_.empty() ? 0 : most); }
  /// True if the type has clouds.
  bool has_clouds() const { return !clouds_.empty(); }

  /// Nothing if the leaf has no points, if a request cannot name the channel, or if there are too many. Any
  /// thread; allocates only for a channel that was never read before.
  std::optional<std::size_t> number_of(std::size_t leaf, std::string_view name);
  /// The fields that are read with the channel of that number. Any thread.
  const FieldMask& fields_of(std::size_t number) const { return channels_[number - leaves_].cloud->fields; }

  /// The whole fields and the channels with these numbers. Where points are whole, so are all fields that say
  /// how they lie; a part has them anyway. Any thread.
  Selection selection(const FieldMask& numbers) const;
  /// Tells how samples differ from what was published if that selection is asked for. Nothing if they do not
  /// differ. Any thread.
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
