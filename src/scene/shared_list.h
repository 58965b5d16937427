// SPDX-License-Identifier: Apache-2.0
#pragma once
// A list whose elements are shared between its copies: copying the list copies pointers, not elements.
//
// An element is read as a constant. edit() copies it first if another list shares it (copy on write), so an edit is
// never seen through another list. There is no operator[] for writing, because it would copy elements by accident.
// Cost: of a copy, one reference count per element; of a look-up, one pointer.

#include <cstddef>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "base/check.h"

namespace gnomon::scene {

template <class T>
class SharedList {
    using Pointers = std::vector<std::shared_ptr<const T>>;

 public:
    class const_iterator {
     public:
        using iterator_category = std::forward_iterator_tag;
        using value_type = T;
        using difference_type = std::ptrdiff_t;
        using pointer = const T*;
        using reference = const T&;

        const_iterator() = default;
        explicit const_iterator(typename Pointers::const_iterator at) : at_(at) {}
        reference operator*() const { return **at_; }
        pointer operator->() const { return at_->get(); }
        const_iterator& operator++()
        {
            ++at_;
            return *this;
        }
        const_iterator operator++(int)
        {
            const_iterator before = *this;
            ++at_;
            return before;
        }
        friend bool operator==(const const_iterator&, const const_iterator&) = default;

     private:
        typename Pointers::const_iterator at_{};
    };

    std::size_t size() const { return items_.size(); }
    bool empty() const { return items_.empty(); }
    const T& operator[](std::size_t i) const { return *items_[i]; }
    const T& at(std::size_t i) const
    {
        GNOMON_CHECK_LT(i, items_.size());
        return *items_[i];
    }
    const T& front() const { return *items_.front(); }
    const T& back() const { return *items_.back(); }
    const_iterator begin() const { return const_iterator(items_.begin()); }
    const_iterator end() const { return const_iterator(items_.end()); }
    /// The element itself, for another list that shares it.
    const std::shared_ptr<const T>& shared(std::size_t i) const { return items_[i]; }

    /// An element to write to; a copy of it takes its place first if another list shares it. References to the shared
    /// element stay with the other list.
    T& edit(std::size_t i)
    {
        GNOMON_CHECK_LT(i, items_.size());
        std::shared_ptr<const T>& item = items_[i];
        if (item.use_count() > 1) item = std::make_shared<T>(*item);
        return const_cast<T&>(*item);   // every element was made without const
    }
    /// Puts another element in the place of one; lists that share the old one keep it.
    void replace(std::size_t i, T value)
    {
        GNOMON_CHECK_LT(i, items_.size());
        items_[i] = std::make_shared<T>(std::move(value));
    }
    void push_back(T value) { items_.push_back(std::make_shared<T>(std::move(value))); }
    /// Shares an element of another list. @pre not null, and made as a T, not as a const T: edit() may write to it
    void push_shared(std::shared_ptr<const T> value)
    {
        GNOMON_CHECK(value);
        items_.push_back(std::move(value));
    }
    template <class... Arguments>
    const T& emplace_back(Arguments&&... arguments)
    {
        items_.push_back(std::make_shared<T>(std::forward<Arguments>(arguments)...));
        return *items_.back();
    }
    void reserve(std::size_t count) { items_.reserve(count); }
    void clear() { items_.clear(); }

 private:
    Pointers items_;
};

}   // namespace gnomon::scene
