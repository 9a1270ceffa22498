/* SPDX-License-Identifier: MIT */
/*
 * ntpio.h - image files to rows of samples and back: PNG, TGA, PFM, WebP; JPEG, DDS, KTX2, EXR (read
 * only)
 *
 * The edge of the project: used by the program, the tests and the bindings, never by libntp.
 * Samples are raw numbers: no color management, gamma, premultiplication or dithering happens
 * here.  Files are read and written row by row, top row first, so an image of any height needs the
 * memory of a few rows.  What cannot stream is held whole, and `info.streams` says so: interlaced
 * PNG, some compressed TGA, progressive JPEG (inside its library), WebP.
 *
 *   open.c     finds the format of a file and delivers its rows; reader.h: what a decoder is
 *   writer.c   joins an encoder with an output; writer.h: what an encoder is
 *   formats.h  the formats, in png_read.c, png_write.c, tga.c, jpeg.c and pfm.c; they know only
 *              reader.h, writer.h and what these include; png_read.c also png_stream.c, which
 *              unpacks most pictures, with inflate.c; png_write.c also png_pack.c, which packs them
 *              band by band, with deflate.c and its parts; both png_filter.c, the row filters;
 *              dds.c and ktx2.c share texture.c (rows of what GPUs take) and layouts.c (formats by
 *              number), which decode blocks by blocks.c and bc7.c
 *              webp.c and exr.c are built where their libraries are there; exr_channels.c: which
 *              channels of an EXR are read
 *   source.c   where bytes come from; stamp.c: which version of a file that is
 *   copy.c     an output that is equal to its input, or but for chunks of a PNG
 *   output.c   where bytes go, and how a file takes the place of its target; attributes.c: what
 *              it keeps of the older file
 *   message.c  the words of errors
 *
 * Every function that can fail fills a ntpio_error with one sentence that names the file.
 */
#ifndef NTPIO_H
#define NTPIO_H

#include <stddef.h>
#include <stdint.h>
#include <stdbool.h>

typedef enum ntpio_status {
    NTPIO_OK = 0,
    NTPIO_ERR_OPEN = 1,    /* missing, a directory, no permission */
    NTPIO_ERR_FORMAT = 2,  /* not an image of a kind that is read here (or built without it) */
    NTPIO_ERR_CORRUPT = 3, /* truncated or damaged */
    NTPIO_ERR_LIMIT = 4,   /* larger than ntpio_limits allow */
    NTPIO_ERR_MEMORY = 5,
    NTPIO_ERR_WRITE = 6, /* no permission, disk full, or the target cannot be replaced */
    NTPIO_ERR_USAGE = 7  /* the format cannot hold what the caller asks for */
} ntpio_status;

typedef struct ntpio_error {
    ntpio_status status;
    char message[512]; /* one UTF-8 sentence, no newline; names the file */
} ntpio_error;

typedef enum ntpio_format {
    NTPIO_PNG = 0,
    NTPIO_TGA = 1,
    NTPIO_JPEG = 2,
    NTPIO_PFM = 3,
    NTPIO_DDS = 4,
    NTPIO_KTX2 = 5,
    NTPIO_WEBP = 6,
    NTPIO_EXR = 7
} ntpio_format;

/* What a reader refuses before it allocates or decodes, and which image of a DDS or KTX2 it
 * delivers. */
typedef struct ntpio_limits {
    uint32_t max_side;    /* 0: 65535 */
    uint64_t max_texels;  /* 0: 2^30 (32768 x 32768) */
    uint64_t max_memory;  /* 0: 4 GiB; for what must be held whole */
    uint64_t max_at_once; /* 0: 256 MiB.  The pixels of PNG files and pictures up to that size are
                             * kept, for ntpio_rewind; larger ones are read in little memory.
                             * 1: libpng does it for all, row by row, which is slower. */
    bool one_pass; /* rows are read once: then PNG files of any size are read in little memory */
    bool regular_only;      /* refuse pipes and devices, without waiting for them */
    uint32_t mip;           /* 0: the largest, 1: half of it, ... */
    uint32_t layer_and_one; /* 1 + the layer of an array, or the face of a cube; 0: none is picked,
                             * and arrays and cubes are refused */
    bool pairs_as_rgb;      /* two channels that are red and green (BC5) come with a blue of 0, as
                             * GPUs sample them */
    bool vectors_as_texels; /* channels X, Y, Z of an EXR, which hold -1..1, come as (v + 1) / 2 */
} ntpio_limits;

/* Which version of a file was read.  A save changes at least one of these. */
typedef struct ntpio_stamp {
    bool known; /* false: it was no regular file */
    uint64_t device, node, size;
    int64_t seconds, nanoseconds; /* of the last change of the content */
} ntpio_stamp;

/* Metadata that is copied to the output, or reported. */
typedef struct ntpio_text {
    char *key;                       /* as in PNG: Latin-1, at most 79 bytes */
    char *value;                     /* UTF-8 when itxt, else Latin-1 */
    char *language, *translated_key; /* iTXt only, else NULL */
    bool compressed, itxt;
} ntpio_text;

typedef struct ntpio_info {
    ntpio_format format;
    uint32_t width, height;
    int32_t channels;     /* of the rows delivered: 1 gray, 2 gray+alpha, 3 RGB, 4 RGBA; or 2
                           * red+green, where red_green says so */
    int32_t sample_bytes; /* of the rows delivered: 1, 2 (native order) or 4 (float) */
    int32_t bit_depth;    /* of a sample in the file: 1, 2, 4, 5 (TGA 15/16 bit), 8, 16, 32 */
    bool streams;
    bool interlaced;
    bool palette;
    bool
        lossy; /* JPEG, WebP and EXR of such kinds, and blocks in which three channels share a line */
    bool red_green; /* the file has two channels, and they are red and green */
    bool vectors;   /* an EXR with channels X, Y, Z: its numbers are -1..1, not 0..1 */
    bool blocks;    /* stored in blocks: BC1 to BC7 */
    bool alpha;     /* the file has an alpha channel or PNG transparency (tRNS) */
    bool has_gama, has_srgb, has_iccp, has_chrm, has_cicp; /* PNG color chunks: never applied;
                                                            * has_srgb: also of a DDS or KTX2 */
    double gamma;                                          /* of gAMA */
    bool has_phys;
    uint32_t phys_x, phys_y; /* pHYs: pixels per unit */
    int32_t phys_unit;       /* 1: metre */
    int32_t jpeg_quality;    /* estimated 1..100; 0 unknown or not JPEG */
    bool jpeg_subsampled;    /* chroma subsampling, e.g. 4:2:0; also of a lossy WebP */
    char layout[32];         /* DDS and KTX2: "BC5", "R8G8B8A8"; else empty */
    uint32_t mips, layers;   /* DDS and KTX2, else 0 */
    ntpio_text *texts;
    size_t text_count;
    ntpio_stamp stamp;  /* of the file when it was opened */
    uint64_t file_size; /* PNG: in bytes; 0: not known (a pipe) */
    bool packed_hard;   /* PNG: its maker says that it took pains; known after the first row */
} ntpio_info;

typedef struct ntpio_reader ntpio_reader;
typedef struct ntpio_writer ntpio_writer;

/*
 * Opens a file.  Its content says what format it is, not its name (except for TGA, which has no
 * signature).  "-" is standard input.  Returns NULL and fills *error on failure.  Samples below 8
 * bits are scaled exactly to 8 (c * 255 / (2^n - 1), rounded); palettes and tRNS become RGB or
 * RGBA. limits may be NULL.
 */
ntpio_reader *ntpio_open(const char *path, const ntpio_limits *limits, ntpio_error *error);

/* The same from bytes in memory, which outlive the reader; `name` is for messages. */
ntpio_reader *ntpio_open_memory(const void *bytes, size_t size, const char *name,
                                const ntpio_limits *limits, ntpio_error *error);

/* Belongs to the reader. */
const ntpio_info *ntpio_reader_info(const ntpio_reader *reader);

/*
 * Reads the next `count` rows into rows at dst, dst + stride, ...; width * channels samples of
 * sample_bytes each.  Returns false and fills *error when the data end or are damaged.
 */
bool ntpio_read_rows(ntpio_reader *reader, void *dst, ptrdiff_t stride, uint32_t count,
                     ntpio_error *error);

/* Back to the first row, if the reader holds the picture.  False: it does not, and has to be opened
 * again.  ntpio_read_end is called once all the same. */
bool ntpio_rewind(ntpio_reader *reader);

/*
 * Unpacks a part more of a picture that is kept for ntpio_rewind.  False: nothing is left, or this
 * reader unpacks rows when they are read.  One other thread may call it again and again while rows are
 * read; it must not run any more when anything else is called.  What is read is the same.
 */
bool ntpio_unpack(ntpio_reader *reader);

/* Is the file at `path` still the version that was read?  True if the stamp is not known. */
bool ntpio_is_current(const char *path, const ntpio_stamp *stamp);

/* After the last row: reads to the end of the image data and checks it (PNG: IEND and the
 * checksum; texts that follow the pixels join the info). */
bool ntpio_read_end(ntpio_reader *reader, ntpio_error *error);

/* Closes the file after the last row, so that it can be replaced: Windows lets nobody replace what is
 * open in certain ways.  The info stays. */
void ntpio_close_file(ntpio_reader *reader);

/* NULL is allowed. */
void ntpio_close(ntpio_reader *reader);

typedef enum ntpio_blocks { NTPIO_BLOCKS_NONE, NTPIO_BLOCKS_BC4, NTPIO_BLOCKS_BC5 } ntpio_blocks;

/* How a DDS or KTX2 is made.  Pictures in memory have no gaps between rows.  Both functions return
 * false if they fail. */
typedef struct ntpio_texture {
    ntpio_blocks blocks;
    bool mips; /* down to 1 x 1 */
    void *context;
    /* Only for mips, only for blocks. */
    bool (*make_mip)(void *context, void *dst, uint32_t width, uint32_t height, const void *whole);
    bool (*compress)(void *context, uint8_t *dst, const void *src, uint32_t width, uint32_t height);
} ntpio_texture;

typedef struct ntpio_write_options {
    ntpio_format format; /* not NTPIO_JPEG, not NTPIO_EXR */
    uint32_t width, height;
    int32_t channels;     /* 1..4 (PFM: 1 or 3; TGA: 1, 3, 4; WebP: 3, 4) */
    int32_t sample_bytes; /* 1, 2 (PNG, DDS, KTX2) or 4 (PFM) */
    int32_t level;        /* PNG, WebP: 1 (fastest) to 12 (smallest; WebP: 9); -1: 6 */
    int32_t threads;      /* PNG: at most so many pack; 0 or 1: the caller's alone.  The bytes
                                  * are the same. */
    bool dry_run;         /* encode nothing, write nothing */
    bool
        without_color; /* ntpio_copy: a PNG that was read, whose gAMA, sRGB, iCCP, cHRM and cICP are
                           * left out */
    const ntpio_info *copy_from;  /* PNG: text chunks and pHYs to keep, or NULL; lives until the
                                  * commit, so that texts after the pixels are kept as well */
    const ntpio_info *as_it_came; /* PNG at level -1: of the file that has the same picture, nearly,
                                   * or NULL.  A file that comes out larger than that one, though
                                   * its maker took pains, is packed again with more. */
    const ntpio_text *texts;      /* PNG: further texts; copied */
    size_t text_count;
    const ntpio_texture *texture; /* DDS, KTX2: lives until the commit; NULL: as it is */
    const char *read_path;        /* the file that the image was made of, or NULL; copied.  The */
    ntpio_stamp read_stamp;       /* commit fails if it is not this version any more. */
} ntpio_write_options;

/*
 * Starts a file.  The bytes go to an unnamed or temporary file beside the target (O_TMPFILE if
 * there is one, else ".NAME.ntp-XXXXXX.tmp").  ntpio_commit syncs that file and puts it in the
 * place of the target.  Until then, and after a failure at any point, an older file of that name
 * stays whole.  Temporary files of the same target are removed if their writer is gone.  A symbolic
 * link stays, and what it leads to is replaced.  Permissions, access control lists and extended
 * attributes are kept (Linux), or the file is refused; owner and group are kept where the system
 * allows it, and another group gets the permissions of everybody else.  A file without write
 * permission is refused.  "-" is standard output; it, pipes and devices are written directly.
 * Programs should ignore SIGXFSZ and SIGPIPE to get errors instead.
 */
ntpio_writer *ntpio_create(const char *path, const ntpio_write_options *options,
                           ntpio_error *error);

bool ntpio_write_rows(ntpio_writer *writer, const void *src, ptrdiff_t stride, uint32_t count,
                      ntpio_error *error);

/* Ends the file, syncs it and puts it in place.  Frees the writer, also on failure. */
bool ntpio_commit(ntpio_writer *writer, ntpio_error *error);

/* Drops what was written.  NULL is allowed. */
void ntpio_abort(ntpio_writer *writer);

/* Writes to `path` what is in the file options->read_path, byte for byte; or `bytes`, unless they are NULL.
 * Of the options, only those about the file that was read count, and without_color. */
bool ntpio_copy(const char *path, const void *bytes, size_t size,
                const ntpio_write_options *options, ntpio_error *error);

/* Does this build read files of that format? */
bool ntpio_reads(ntpio_format format);

/* "libpng 1.6.39, zlib 1.2.13, libjpeg-turbo 2.1.5": what this build reads and writes with. */
const char *ntpio_versions(void);

#endif
