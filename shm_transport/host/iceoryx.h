// Includes the headers of iceoryx that the transport uses.
//
// The transport uses iceoryx below its public API, where calls fail with values instead of aborting: the
// ports (PublisherPortUser and SubscriberPortUser), the messages between programs and the daemon, and the
// layout of the management segment. None of these changed between 2.0.3 and 2.0.8, which is why
// CMakeLists.txt accepts this range of versions. sftd and the programs must be built with the same version,
// because they share the layout: a daemon refuses programs with another version.
#pragma once

#include <iceoryx_hoofs/cxx/generic_raii.hpp>
#include <iceoryx_hoofs/error_handling/error_handling.hpp>
#include <iceoryx_hoofs/internal/relocatable_pointer/base_relative_pointer.hpp>
#include <iceoryx_hoofs/log/logmanager.hpp>
#include <iceoryx_hoofs/posix_wrapper/posix_access_rights.hpp>
#include <iceoryx_posh/iceoryx_posh_types.hpp>
#include <iceoryx_posh/internal/mepoo/memory_manager.hpp>
#include <iceoryx_posh/internal/mepoo/segment_manager.hpp>
#include <iceoryx_posh/internal/popo/ports/publisher_port_user.hpp>
#include <iceoryx_posh/internal/popo/ports/subscriber_port_user.hpp>
#include <iceoryx_posh/internal/roudi/port_pool_data.hpp>
#include <iceoryx_posh/internal/runtime/ipc_interface_base.hpp>
#include <iceoryx_posh/internal/runtime/ipc_message.hpp>
#include <iceoryx_posh/runtime/port_config_info.hpp>
#include <iceoryx_posh/version/version_info.hpp>
#include <iceoryx_versions.hpp>

namespace sft::shm {

/// The maximum number of places in a queue between a writer and a reader. A place can have one chunk.
inline constexpr std::uint64_t queue_places_max = iox::MAX_SUBSCRIBER_QUEUE_CAPACITY;

// The limits with which iceoryx was built.
inline constexpr std::uint32_t processes_max = iox::MAX_PROCESS_NUMBER;
inline constexpr std::uint32_t writers_max = iox::MAX_PUBLISHERS - iox::NUMBER_OF_INTERNAL_PUBLISHERS;
inline constexpr std::uint32_t readers_max = iox::MAX_SUBSCRIBERS;

}  // namespace sft::shm

// The following functions are defined in replaced_functions.cpp. The declarations keep the compiler from
// instantiating iceoryx's templates.
namespace iox::concurrent {

template <>
void IndexQueue<sft::shm::queue_places_max, std::uint64_t>::push(std::uint64_t place) noexcept;
template <>
bool IndexQueue<sft::shm::queue_places_max, std::uint64_t>::pop(std::uint64_t& place) noexcept;
template <>
bool IndexQueue<sft::shm::queue_places_max, std::uint64_t>::popIfSizeIsAtLeast(std::uint64_t size,
                                                                               std::uint64_t& place) noexcept;
template <>  // This function is not replaced, since no queue of SFT calls it.
bool IndexQueue<sft::shm::queue_places_max, std::uint64_t>::popIfFull(std::uint64_t& place) noexcept = delete;

}  // namespace iox::concurrent
