// expect: (use of|call to) deleted (member )?function .*view
#include "tests/compile_fail/cloud.h"

auto misuse(sft::DynamicSubscriber& subscriber) { return subscriber.take().view(); }
