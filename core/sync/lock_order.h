// The order in which a thread takes locks if it holds several at a time. Such locks are on levels: a thread
// that holds a lock may take locks of later levels only. Three kinds of mutexes are on no level: mutexes
// that are only locked while no other mutex is held, mutexes under which no other mutex is locked, and the
// mutexes of discovery, which a thread never locks while it holds a lock on a level.
//
// Each mutex on a level names the levels between which it lies. Clang (-Wthread-safety-beta) refuses a
// function that takes two locks in the wrong order, and declarations that form a cycle. Clang checks one
// function at a time. It does not see a lock that a called function takes, unless that function is
// annotated.
#pragma once

#include "core/sync/thread_annotations.h"

namespace sft::core::lock_order {

/// The border between two levels. It is never locked.
struct SFT_CAPABILITY("level") Border {};

/// The level of the registry of endpoints, which is locked while the status of the endpoints is read:
/// EndpointRegistry.
inline constexpr Border endpoints{};
/// The level of the mutexes of one endpoint: PublisherCore, SubscriberPorts, RemoteCopy.
inline constexpr Border endpoint SFT_ACQUIRED_AFTER(endpoints){};
/// The level of the queues of one endpoint or of one remote socket: Inbox, ShmReaderPort, Lane, Channel,
/// ChannelRegistry, DestinationDirectory, ScheduledWork, SubscriptionDirectory.
inline constexpr Border queues SFT_ACQUIRED_AFTER(endpoint){};
/// The level of the objects with state that several queues share: RemotePath, SharedFlowWindow, DeliveryBook,
/// GroupReasons, Published.
inline constexpr Border facts SFT_ACQUIRED_AFTER(queues){};
/// The level of the pool to which jobs return, and of the budget for unproven sockets: JobPool,
/// UnprovenBudget.
inline constexpr Border jobs SFT_ACQUIRED_AFTER(facts){};
// The level after `jobs` has the owners of the memory of samples: BufferPool, ShmWriterPort, ChunkQueue. The
// thread that releases the last handle of a sample locks their mutexes. While it holds them, it may take
// locks of iceoryx.

}  // namespace sft::core::lock_order
