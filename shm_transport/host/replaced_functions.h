// Five functions of iceoryx that SFT replaces in its processes, because they can give one chunk to two
// owners:
//
// - LoFFLi::pop() and push(), the list of the free chunks of a pool. A failed exchange of the head counts on
//   from its own old count, not from that of the head. So counts come again, and an exchange that should fail
//   succeeds.
// - IndexQueue::push(), pop() and popIfSizeIsAtLeast(), the places of a queue between a writer and a reader.
//   They order nothing. On a CPU that reorders memory accesses a reader can see a place before its element.
//
// same_host.md says what the replacements rely on, tests/model has both as models. iceoryx calls these
// functions through the tables of the dynamic linker, also where it has them itself (each build of Debian 12
// and 13 does), and the linker takes the first definition that it finds: a program that has this file linked
// in, and libsft.so, exports them. All processes that share memory need them, so host_protocol was raised for
// them.
#pragma once

namespace sft::shm {

/// Returns whether iceoryx calls the replacements in this process. It does not if its libraries were loaded
/// before libsft.so, as by a program that loads libsft.so later.
bool functions_are_replaced();

/// The message to a program that must not use shared memory for this reason.
inline constexpr const char* not_replaced =
    "this process has loaded iceoryx before SFT, so that SFT cannot mend iceoryx's lists of free chunks; "
    "link "
    "the program to libsft, or load libsft.so before iceoryx (LD_PRELOAD)";

}  // namespace sft::shm
