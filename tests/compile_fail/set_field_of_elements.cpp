// expect: set[(][)] takes a scalar field outside sequences of structs
#include "tests/compile_fail/cloud.h"

void misuse(sft::Loan<PointCloud2>& loan) { loan.set(F::fields.each.count, 1); }
