// Five functions of iceoryx that SFT replaces in its processes, because they can give one chunk to two
// owners:
//
// - LoFFLi::pop() and push(), the list of the free chunks of a pool. After a failed exchange of the head,
//   the next attempt increments the count of the failed attempt, not the count of the present head. So
//   counts are repeated, and an exchange that should fail succeeds.
// - IndexQueue::push(), pop() and popIfSizeIsAtLeast(), the places of a queue between a writer and a reader.
//   These functions do not order memory accesses. On a CPU that reorders memory accesses, a reader can see a
//   place before the element in that place.
//
// same_host.md says what the replacements rely on. tests/model has models of iceoryx's functions and of the
// replacements. iceoryx calls these functions through the tables of the dynamic linker, even if it contains
// them itself (each build of Debian 12 and 13 does). The linker takes the first definition that it finds.
// libsft.so, or a program that has this file linked in, exports the replacements. All processes that share
// memory need the replacements, so host_protocol was raised for them.
#pragma once

namespace sft::shm {

/// Returns whether iceoryx calls the replacements in this process. iceoryx does not call them if its
/// libraries were loaded before libsft.so, for example in a program that loads libsft.so later.
bool functions_are_replaced();

/// The message to a program that must not use shared memory because the functions are not replaced.
inline constexpr const char* not_replaced =
    "this process has loaded iceoryx before SFT, so that SFT cannot mend iceoryx's lists of free chunks; "
    "link "
    "the program to libsft, or load libsft.so before iceoryx (LD_PRELOAD)";

}  // namespace sft::shm
