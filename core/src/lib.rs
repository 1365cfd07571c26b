#![no_std]
//! The outer loop.
