/* SPDX-License-Identifier: MIT */
/*
 * mixed_tmpl.h - a part of mix_avx2.c: blends vectors, in registers of NUMBER
 *
 * The formulas are those of blend.c; M of both textures is the same.  *product: t.u, else 0.
 */
static inline void MIXED(NUMBER v[3], NUMBER *product, const NUMBER b[3], const NUMBER d[3],
                         const terms *t)
{
    const NUMBER m = OP(set1)(t->m);
    const NUMBER dx = OP(mul)(OP(set1)(t->strength), d[0]), dy = OP(mul)(OP(set1)(t->turn), d[1]);
    if (t->reoriented) {
        const NUMBER tz = OP(add)(b[2], m), scale = OP(mul)(tz, m);
        const NUMBER dot =
            OP(sub)(OP(mul)(tz, d[2]), OP(add)(OP(mul)(b[0], dx), OP(mul)(b[1], dy)));
        *product = dot;
        v[0] = OP(add)(OP(mul)(dot, b[0]), OP(mul)(scale, dx));
        v[1] = OP(add)(OP(mul)(dot, b[1]), OP(mul)(scale, dy));
        v[2] = OP(sub)(OP(mul)(dot, tz), OP(mul)(scale, d[2]));
        return;
    }
    *product = OP(setzero)();
    const NUMBER by_d = OP(add)(OP(set1)(t->base_z), OP(mul)(OP(set1)(t->product), d[2]));
    v[0] = OP(mul)(OP(add)(b[0], dx), m);
    v[1] = OP(mul)(OP(add)(b[1], dy), m);
    v[2] = OP(add)(OP(mul)(b[2], by_d), OP(mul)(OP(set1)(t->detail_z), d[2]));
}
