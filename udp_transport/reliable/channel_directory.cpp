#include "udp_transport/reliable/channel_directory.h"

#include <algorithm>

namespace sft::udp {

void ChannelRegistry::add(const std::shared_ptr<Channel>& channel) {
  const core::Lock lock(mutex_);
  std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
  known_[{channel->writer(), channel->number()}] = channel;
}

std::shared_ptr<Channel> ChannelRegistry::find(std::uint32_t writer, std::uint32_t number) {
  const core::Lock lock(mutex_);
  const auto known = known_.find({writer, number});
  return known == known_.end() ? nullptr : known->second.lock();
}

std::vector<std::shared_ptr<Channel>> ChannelRegistry::find_at(std::uint32_t writer,
                                                               const core::IpAddress& ip) {
  std::vector<std::shared_ptr<Channel>> found;
  const core::Lock lock(mutex_);
  for (auto one = known_.lower_bound({writer, 0}); one != known_.end() && one->first.first == writer; ++one) {
    std::shared_ptr<Channel> channel = one->second.lock();
    if (channel != nullptr && channel->destination().path().is_at(ip)) found.push_back(std::move(channel));
  }
  return found;
}

/// If none of the former readers stays, a new channel is made, because the new readers must not get samples
/// that were sent to the former ones.
std::shared_ptr<Channel> ChannelDirectory::find(const std::shared_ptr<Destination>& to,
                                                const std::set<core::EndpointId>& readers) {
  Known& known = channels_[to.get()];
  std::shared_ptr<Channel> channel = known.channel.lock();
  const bool some_stay =
      std::ranges::any_of(readers, [&](core::EndpointId reader) { return known.readers.contains(reader); });
  known.readers = readers;
  if (channel != nullptr && some_stay && !channel->closed()) return channel;
  if (channel != nullptr) {
    channel->close();
    closed_ = true;
  }
  channel = std::make_shared<Channel>(writer_, unused_number(*to), to, tally_, ack_port_, memory_);
  registry_.add(channel);
  known.channel = channel;
  return channel;
}

/// Returns an unused number. 0 is not used, because it means no channel. Used numbers are skipped, because
/// those of different destinations can be equal by chance.
std::uint32_t ChannelDirectory::unused_number(const Destination& to) {
  for (;;) {
    const std::uint32_t number = to.name_of_channel(++last_number_);
    if (number != 0 && registry_.find(writer_, number) == nullptr) return number;
  }
}

bool ChannelDirectory::any_channel_failed() const {
  return std::ranges::any_of(channels_, [](const auto& item) {
    const std::shared_ptr<Channel> channel = item.second.channel.lock();
    return channel != nullptr && channel->went_wrong();
  });
}

void ChannelDirectory::keep_to(const ReliableReaders& readers) {
  std::erase_if(channels_, [](const auto& item) { return item.second.channel.expired(); });
  for (auto& [to, known] : channels_) {
    const std::shared_ptr<Channel> channel = known.channel.lock();
    if (channel == nullptr || known.readers.empty() || readers.contains(to)) continue;
    channel->end();
    closed_ = true;
    known.readers.clear();
  }
}

}  // namespace sft::udp
