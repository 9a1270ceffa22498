/* SPDX-License-Identifier: MIT */
/* Windows has none; popt asks the console for its width only where TIOCGWINSZ is defined. */
