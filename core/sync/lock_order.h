// The order in which a thread takes locks, if it holds several at a time. Such locks are on levels: a thread
// that holds a lock may take locks of later levels only. A mutex that is on no level is the only one that a
// thread holds at that time, or the last one that it takes, or one of those of discovery, which no thread
// takes that holds a lock on a level.
//
// Each mutex on a level names the levels between which it lies. Clang (-Wthread-safety-beta) refuses a
// function that takes two locks in the wrong order, and an order that leads back to its beginning. Clang
// looks at one function at a time: it does not see a lock that another function takes, unless that function
// is marked.
#pragma once

#include "core/sync/thread_annotations.h"

namespace sft::core::lock_order {

/// The border between two levels. It is never locked.
struct SFT_CAPABILITY("level") Border {};

/// Endpoints are asked for their status: EndpointRegistry.
inline constexpr Border endpoints{};
/// One endpoint: PublisherCore, SubscriberPorts, RemoteCopy.
inline constexpr Border endpoint SFT_ACQUIRED_AFTER(endpoints){};
/// What one endpoint, or one remote socket, has to send or to receive: Inbox, ShmReaderPort, Lane, Channel,
/// ChannelRegistry, DestinationDirectory, ScheduledWork, SubscriptionDirectory.
inline constexpr Border queues SFT_ACQUIRED_AFTER(endpoint){};
/// Facts that several of these share: RemotePath, SharedFlowWindow, DeliveryBook, GroupReasons, Published.
inline constexpr Border facts SFT_ACQUIRED_AFTER(queues){};
/// Jobs that are given back, and what has not been proven: JobPool, UnprovenBudget.
inline constexpr Border jobs SFT_ACQUIRED_AFTER(facts){};
// Behind `jobs` lies the memory of samples, which is given back by the thread that drops the last handle:
// BufferPool, ChunkLender, ChunkQueue. They may take locks of iceoryx.

}  // namespace sft::core::lock_order
