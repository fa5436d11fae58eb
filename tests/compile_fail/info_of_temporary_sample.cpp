// expect: (use of|call to) deleted (member )?function .*info
#include "tests/compile_fail/cloud.h"

auto misuse(sft::Subscriber<PointCloud2, F::height>& subscriber) { return subscriber.take().info(); }
