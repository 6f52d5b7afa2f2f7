// SPDX-License-Identifier: Apache-2.0
// A symbol that libc++abi expects and the libc of this target lacks: destructors of objects of a thread.
// There is one thread, which does not end.
extern "C" int __cxa_thread_atexit(void (*)(void*), void*, void*) { return 0; }
