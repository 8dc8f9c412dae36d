/* main() of the tests that have nothing to prepare.  Weak, because the others have their own. */
int check_main(void);
int main(void);
__attribute__((weak)) int main(void) { return check_main(); }
