// Annotations of the order in which TBB runs tasks, for the thread sanitizer.
//
// Linked into every program of a build with KINDLING_SANITIZE=thread. Debian's TBB is not compiled
// with the sanitizer, which therefore sees neither that a task starts after it was spawned nor that
// a wait ends after its tasks. Suppressing all that has TBB on its stack would hide races within
// tasks too. These definitions replace TBB's entry points (a program's own precede those of a
// library), annotate the order and call TBB's. The counts in TBB's headers, which also order tasks,
// are compiled with the sanitizer. Memory comes from malloc, which the sanitizer knows, and not
// from TBB's pools. The uses of TBB in Kindling are covered: algorithms, task_group and
// task_arena::execute; not enqueue, flow graphs or suspended tasks.
// SPDX-License-Identifier: Apache-2.0
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <cstdint>
#include <cstdlib>
#include <dlfcn.h>
#include <sanitizer/tsan_interface.h>

// Functions of the sanitizer's library that no header declares.
extern "C" void AnnotateIgnoreWritesBegin(const char* file, int line);
extern "C" void AnnotateIgnoreWritesEnd(const char* file, int line);

namespace tbb::detail::r1 {
namespace {

// Returns TBB's own function of this mangled name.
template <typename Function>
Function* library(const char* name) {
  void* const function = dlsym(RTLD_NEXT, name);
  if (!function) std::abort(); // a different version of TBB
  return reinterpret_cast<Function*>(function);
}

// Wraps a spawned task: the spawn happens before the task.
class OrderedTask final : public d1::task {
 public:
  explicit OrderedTask(d1::task& inner) : task_(inner) { __tsan_release(this); }
  // TBB calls cancel() next if this throws.
  d1::task* execute(d1::execution_data& data) override {
    __tsan_acquire(this);
    d1::task* const next = task_.execute(data);
    delete this;
    return next;
  }
  d1::task* cancel(d1::execution_data& data) override {
    __tsan_acquire(this);
    d1::task* const next = task_.cancel(data);
    delete this;
    return next;
  }

 private:
  d1::task& task_;
};

// Guard whose end, with an exception too, annotates that tasks which have left the count of a
// wait_context happen before the end of its wait.
struct WaitEnd {
  const d1::wait_context& context;
  // The count is the second member; TBB's headers decrement it.
  ~WaitEnd() { __tsan_acquire(const_cast<std::uint64_t*>(reinterpret_cast<const std::uint64_t*>(&context)) + 1); }
};
static_assert(sizeof(d1::wait_context) == 2 * sizeof(std::uint64_t));

// TBB may run it on a thread of the arena.
class OrderedDelegate final : public d1::delegate_base {
 public:
  explicit OrderedDelegate(d1::delegate_base& delegate) : delegate_(delegate) { __tsan_release(this); }
  ~OrderedDelegate() { __tsan_acquire(this); }
  bool operator()() const override {
    auto* const self = const_cast<OrderedDelegate*>(this);
    __tsan_acquire(self);
    const bool result = delegate_();
    __tsan_release(self);
    return result;
  }

 private:
  d1::delegate_base& delegate_;
};

void* aligned(std::size_t bytes) {
  constexpr std::size_t kLine = 128; // as TBB's
  void* const memory = std::aligned_alloc(kLine, (bytes + kLine - 1) / kLine * kLine);
  if (!memory) std::abort();
  return memory;
}

} // namespace

void spawn(d1::task& task, d1::task_group_context& context) {
  static auto* const original = library<void(d1::task&, d1::task_group_context&)>(
      "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextE");
  original(*new OrderedTask(task), context);
}

void spawn(d1::task& task, d1::task_group_context& context, d1::slot_id slot) {
  static auto* const original = library<void(d1::task&, d1::task_group_context&, d1::slot_id)>(
      "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextEt");
  original(*new OrderedTask(task), context, slot);
}

// The first task runs on this thread.
void execute_and_wait(d1::task& task, d1::task_group_context& task_context, d1::wait_context& wait_context,
                      d1::task_group_context& context) {
  static auto* const original =
      library<void(d1::task&, d1::task_group_context&, d1::wait_context&, d1::task_group_context&)>(
          "_ZN3tbb6detail2r116execute_and_waitERNS0_2d14taskERNS2_18task_group_contextERNS2_12wait_contextES6_");
  const WaitEnd end{wait_context};
  original(task, task_context, wait_context, context);
}

void wait(d1::wait_context& wait_context, d1::task_group_context& context) {
  static auto* const original = library<void(d1::wait_context&, d1::task_group_context&)>(
      "_ZN3tbb6detail2r14waitERNS0_2d112wait_contextERNS2_18task_group_contextE");
  const WaitEnd end{wait_context};
  original(wait_context, context);
}

void execute(d1::task_arena_base& arena, d1::delegate_base& delegate) {
  static auto* const original = library<void(d1::task_arena_base&, d1::delegate_base&)>(
      "_ZN3tbb6detail2r17executeERNS0_2d115task_arena_baseERNS2_13delegate_baseE");
  OrderedDelegate ordered(delegate);
  original(arena, ordered);
}

void* allocate(d1::small_object_pool*& pool, std::size_t bytes) {
  static char none; // the headers need a pool that is not null
  pool = reinterpret_cast<d1::small_object_pool*>(&none);
  return aligned(bytes);
}
void* allocate(d1::small_object_pool*& pool, std::size_t bytes, const d1::execution_data&) {
  return allocate(pool, bytes);
}
void deallocate(d1::small_object_pool&, void* memory, std::size_t) { std::free(memory); }
void deallocate(d1::small_object_pool&, void* memory, std::size_t, const d1::execution_data&) { std::free(memory); }
void* cache_aligned_allocate(std::size_t bytes) { return aligned(bytes); }
// TBB also calls it for its own memory, from threads whose order the sanitizer does not see.
void cache_aligned_deallocate(void* memory) {
  AnnotateIgnoreWritesBegin(__FILE__, __LINE__);
  std::free(memory);
  AnnotateIgnoreWritesEnd(__FILE__, __LINE__);
}

} // namespace tbb::detail::r1
