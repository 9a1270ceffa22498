/* SPDX-License-Identifier: MIT */
/*
 * judgement.h - what the rules of this room share
 */
#ifndef NTP_CLI_JUDGEMENT_H
#define NTP_CLI_JUDGEMENT_H

#include "findings/findings.h"

/* A file that is being judged. */
typedef struct judgement {
    finding_list *list;
    const facts *f;
    const judge_rules *rules;
    uint64_t used; /* texels that are judged */
} judgement;

void add_finding(judgement *j, finding_id id, finding_level level, uint64_t count, const text *t);
void TEXT_FORMAT(5, 6)
    addf(judgement *j, finding_id id, finding_level level, uint64_t count, const char *format, ...);
/* "12.3 % of the texels (12,345)" */
void add_share(const judgement *j, text *t, uint64_t count);

/* Above --max-fail an error, else a warning. */
finding_level level_of_share(const judgement *j, uint64_t count);
/* By what a renderer shows, for every format and depth. */
finding_level level_of_harm(const judgement *j, const ntp_harm *harm);

/* Of what makes lengths wrong, such as compression: a warning where they are visibly wrong. */
finding_level level_of_cause(const judgement *j);

/* Are its texels normals in tangent space? */
bool is_judged(const facts *f);
/* Is z not in blue, or are the numbers not those of normals? */
bool has_misplaced_channels(const facts *f);

void judge_class(judgement *j);
void judge_accidents(judgement *j);
void judge_texels(judgement *j);
void judge_file(judgement *j);

#endif
