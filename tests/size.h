/* How large a test's inputs are.
 *
 * The thread sanitizer makes every access to memory ten to thirty times slower, and looks at how
 * threads meet rather than at figures. In its build (STP_TEST_SMALL, tests/CMakeLists.txt) tests
 * that would take an hour take smaller inputs; what they assert stays the same. */
#ifndef STP_TESTS_SIZE_H
#define STP_TESTS_SIZE_H

#ifdef STP_TEST_SMALL
#define TEST_SIZE(full, small) (small)
#else
#define TEST_SIZE(full, small) (full)
#endif

#endif
