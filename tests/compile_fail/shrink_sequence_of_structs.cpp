// expect: (no matching (member )?function for call to .*shrink|shrink[(][)] takes a sequence)
#include "tests/compile_fail/cloud.h"

void misuse(sft::Loan<PointCloud2>& loan) { loan.shrink(F::fields, 1); }
