/* SPDX-License-Identifier: MIT */
/*
 * mixed_tmpl.h - a part of mix_avx2.c and mix_avx512.c: blends vectors, in registers of NUMBER
 *
 * The formulas are those of blend.c; M of both textures is the same.  With FOURS, whole numbers are
 * summed as mix_avx2.c says.
 */
static inline void MIXED(ntp__mix_planes v, ntp__mix_planes base, ntp__mix_planes detail, int32_t n,
                         const ntp__mix_terms *t)
{
    const NUMBER m = OP(set1)(t->m), strength = OP(set1)(t->strength), turn = OP(set1)(t->turn);
    for (int32_t i = 0; i < n; i += (int32_t) (sizeof(NUMBER) / sizeof(ELEMENT))) {
        const NUMBER bx = LOAD(base[0] + i), by = LOAD(base[1] + i), bz = LOAD(base[2] + i);
        const NUMBER dx = OP(mul)(strength, LOAD(detail[0] + i));
        const NUMBER dy = OP(mul)(turn, LOAD(detail[1] + i)), dz = LOAD(detail[2] + i);
        NUMBER x, y, z;
        if (t->reoriented) {
            const NUMBER tz = OP(add)(bz, m), scale = OP(mul)(tz, m);
            NUMBER dot = OP(fmsub)(tz, dz, OP(fmadd)(bx, dx, OP(mul)(by, dy)));
            x = OP(mul)(scale, dx);
            y = OP(mul)(scale, dy);
            z = OP(mul)(scale, dz);
#ifdef FOURS
            const NUMBER fours = OP(set1)(FOURS), part = OP(sub)(OP(add)(dot, fours), fours);
            const NUMBER rest = OP(sub)(dot, part);
            x = OP(fmadd)(rest, bx, x);
            y = OP(fmadd)(rest, by, y);
            z = OP(fnmadd)(rest, tz, z);
            dot = part;
#endif
            x = OP(fmadd)(dot, bx, x);
            y = OP(fmadd)(dot, by, y);
            z = OP(fmsub)(dot, tz, z);
        } else {
            x = OP(mul)(OP(add)(bx, dx), m);
            y = OP(mul)(OP(add)(by, dy), m);
            z = OP(mul)(bz, OP(fmadd)(OP(set1)(t->product), dz, OP(set1)(t->base_z)));
            z = OP(fmadd)(OP(set1)(t->detail_z), dz, z);
        }
        STORE(v[0] + i, x);
        STORE(v[1] + i, y);
        STORE(v[2] + i, z);
    }
}

#undef NUMBER
#undef ELEMENT
#undef OP
#undef MIXED
#undef LOAD
#undef STORE
#undef FOURS
